//! Messages: JSON and the bytes that belong to it.

use serde::Serialize;

/// Bytes of a length.
const LENGTH: usize = size_of::<u32>();

/// An encoded message.
pub type Reply = Vec<u8>;

#[derive(Serialize)]
struct Failure<'a> {
    error: &'a str,
}

/// The JSON of a message and the rest of it.
pub(crate) fn split(message: &[u8]) -> Option<(&str, &[u8])> {
    let (length, rest) = message.split_first_chunk::<LENGTH>()?;
    let (json, bytes) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    Some((std::str::from_utf8(json).ok()?, bytes))
}

/// A message.
#[must_use]
pub fn reply(json: &impl Serialize, bytes: &[u8]) -> Reply {
    let json = serde_json::to_vec(json).unwrap_or_default();
    let length = u32::try_from(json.len()).unwrap_or_default().to_le_bytes();
    [&length[..], &json, bytes].concat()
}

/// The message that something failed.
#[must_use]
pub fn error(what: &str) -> Reply {
    reply(&Failure { error: what }, &[])
}

/// Numbers as the page reads them.
pub(crate) fn floats(values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    values.into_iter().flat_map(|value| (value as f32).to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_split_where_it_was_joined() {
        let message = reply(&[1, 2], b"rest");
        assert_eq!(split(&message), Some(("[1,2]", &b"rest"[..])));
        assert_eq!(split(&message[..7]), None);
        assert_eq!(split(b"\xff\xff\xff\xff{}"), None);
        assert_eq!(split(b"\x01\0\0\0\xff"), None);
        assert_eq!(split(b""), None);
    }
}
