//! The public algorithms of the core are documented: how exact, how dear, by which formats, after whom, with an example.

use std::path::Path;

/// What the documentation of an algorithm must have, by file and the line that declares it.
const ALGORITHMS: [(&str, &str, &[&str]); 31] = [
    ("map/plan/pack.rs", "pub fn pack<", &["# Errors", "```"]),
    ("map/plan/mod.rs", "pub fn new(", &["# Errors"]),
    ("map/plan/march.rs", "pub fn scan(", &["# Cost", "# Errors", "```"]),
    ("map/plan/march.rs", "pub fn rays(", &["# Errors"]),
    ("map/site/view.rs", "pub fn new(", &["# Errors"]),
    ("descriptor/channels.rs", "pub fn fill(", &["# Formats", "# Accuracy", "# References", "```"]),
    ("descriptor/spectrum/fft.rs", "pub fn forward(", &["# Formats", "# Accuracy", "# Cost", "```"]),
    ("descriptor/spectrum/fft.rs", "pub fn inverse(", &["# Formats", "```"]),
    ("descriptor/matching/shortlist.rs", "pub fn shortlist(", &["# Cost", "```"]),
    ("descriptor/matching/exact.rs", "pub fn exhaustive(", &["# Cost", "```"]),
    ("descriptor/signature.rs", "pub fn new(", &["# Formats", "```"]),
    ("descriptor/windows/mod.rs", "pub fn find(", &["# Cost", "# References", "# Errors", "```"]),
    ("vision/segments/mod.rs", "pub fn detect(", &["# Formats", "# Cost", "# References", "# Errors", "```"]),
    ("vision/segments/mod.rs", "pub fn smooth(", &["# Formats", "# Accuracy", "```"]),
    ("vision/attitude/search.rs", "pub fn vertical(", &["# Accuracy", "# Cost", "# References", "```"]),
    ("vision/attitude/axes.rs", "pub fn building_axes(", &["# Formats", "```"]),
    ("vision/windows/mod.rs", "pub struct WindowFinder", &["# Formats", "# Cost", "# References", "```"]),
    ("vision/boundary/mod.rs", "pub struct BoundaryFinder", &["# Formats", "# Accuracy", "# Cost", "```"]),
    ("vision/boundary/ranges.rs", "pub fn ranges(", &["# Formats", "# Accuracy", "# Cost", "```"]),
    ("vision/boundary/ranges.rs", "pub fn guess_ceiling(", &["# Formats", "# Cost"]),
    ("vision/camera/kannala_brandt.rs", "pub struct KannalaBrandt", &["# Cost", "# References", "```"]),
    ("vision/lens_field.rs", "pub fn fill_mask(", &["# Formats", "```"]),
    ("vision/visual_scan.rs", "pub fn scan(", &["# Formats", "```"]),
    ("pose/evidence.rs", "pub fn weigh(", &["# Formats", "# Cost", "```"]),
    ("pose/search.rs", "pub fn search<", &["# Formats", "# Cost", "```"]),
    ("pose/refine.rs", "pub fn refine(", &["# Cost", "```"]),
    ("pose/locate.rs", "pub fn locate<", &["# Cost"]),
    ("pose/track/mod.rs", "pub fn step(", &["# Cost", "```"]),
    ("pose/wall_check.rs", "pub fn compare(", &["# Formats", "```"]),
    ("base/num.rs", "pub fn cos_sin(", &["# Accuracy", "```"]),
    ("locator/mod.rs", "pub fn locate(", &["# Errors"]),
];

/// The documentation above the first line that begins like this, attributes passed over.
fn documentation(text: &str, declaration: &str) -> Option<String> {
    let lines: Vec<_> = text.lines().map(str::trim_start).collect();
    let at = lines.iter().position(|line| line.starts_with(declaration))?;
    let above = lines[..at].iter().rev();
    let docs =
        above.take_while(|line| line.starts_with("//") || line.starts_with('#') || line.starts_with(')'));
    Some(docs.filter(|line| line.starts_with("///")).map(|line| format!("{line}\n")).collect())
}

/// The headings that are missing, in words.
fn missing(text: &str, declaration: &str, wanted: &[&str]) -> Vec<String> {
    let Some(docs) = documentation(text, declaration) else { return vec![format!("no {declaration}")] };
    wanted
        .iter()
        .filter(|heading| !docs.contains(*heading))
        .map(|h| format!("{declaration} lacks {h}"))
        .collect()
}

#[test]
fn public_algorithms_have_their_headings() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../compass-core/src");
    let lacking = ALGORITHMS.iter().flat_map(|(file, declaration, wanted)| {
        let text = std::fs::read_to_string(source.join(file)).unwrap();
        missing(&text, declaration, wanted).into_iter().map(move |lack| format!("{file}: {lack}"))
    });
    let lacking: Vec<_> = lacking.collect();
    assert!(lacking.is_empty(), "{lacking:#?}");
}

#[test]
fn a_heading_that_is_missing_is_found() {
    let text = "/// Adds.\n///\n/// # Cost\n/// One addition.\n#[must_use]\npub fn add(a: u8, b: u8) -> u8 {";
    assert!(missing(text, "pub fn add(", &["# Cost"]).is_empty());
    assert_eq!(missing(text, "pub fn add(", &["# Cost", "# Errors"]), ["pub fn add( lacks # Errors"]);
    assert_eq!(missing(text, "pub fn sub(", &["# Cost"]), ["no pub fn sub("]);
}
