//! What JavaScript calls. Pointers go out and never come in, so nothing here can be misused.

use crate::message::{error, split};
use crate::session::Session;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The session, and the buffers of the message that comes and of the one that goes.
static STATE: Mutex<Option<Box<State>>> = Mutex::new(None);

#[derive(Default)]
struct State {
    session: Session,
    request: Vec<u8>,
    reply: Vec<u8>,
}

fn state() -> MutexGuard<'static, Option<Box<State>>> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Room for a request of so many bytes: where to write it.
#[unsafe(no_mangle)]
pub extern "C" fn compass_request(bytes: usize) -> *mut u8 {
    let mut state = state();
    let State { request, .. } = &mut **state.get_or_insert_default();
    request.clear();
    request.resize(bytes, 0);
    request.as_mut_ptr()
}

/// Answers the request that was written: the length of the reply, which is at [`compass_reply`].
#[unsafe(no_mangle)]
pub extern "C" fn compass_answer() -> usize {
    let mut state = state();
    let State { session, request, reply } = &mut **state.get_or_insert_default();
    // Files that were read need not lie here twice.
    let request = std::mem::take(request);
    *reply = match split(&request) {
        Some((json, bytes)) => session.answer(json, bytes),
        None => error("not a request: its length is that of no JSON text"),
    };
    reply.len()
}

/// Where the last reply is, until the next request.
#[unsafe(no_mangle)]
pub extern "C" fn compass_reply() -> *const u8 {
    state().get_or_insert_default().reply.as_ptr()
}
