//! `compass fit` on results of `compass evaluate`.

use compass_tests::{Folder, number};
use serde_json::{Value, json};

/// A result with as many right and wrong frames at each lead as asked for.
fn result(counts: &[(f64, usize, usize)]) -> String {
    let frame = |lead: f64, off: f64| json!({ "lead": lead, "single": { "position_error_m": off, "heading_error_deg": -0.5, "x": 1.0 } });
    let frames = counts.iter().flat_map(|&(lead, right, wrong)| {
        let right = (0..right).map(move |_| frame(lead, 0.1));
        right.chain((0..wrong).map(move |_| frame(lead, 7.0)))
    });
    let unseen = json!({ "lead": 0.0, "single": Value::Null });
    json!({ "frames": 3, "results": frames.chain([unseen]).collect::<Vec<_>>() }).to_string()
}

#[test]
fn a_probability_is_fitted_to_results() {
    let folder = Folder::new();
    folder.write("a.json", result(&[(10.0, 2, 8), (50.0, 5, 5), (90.0, 8, 2)]).as_bytes());
    folder.write("b.json", result(&[(10.0, 2, 8), (90.0, 8, 2)]).as_bytes());
    folder.write("c.json", result(&[(10.0, 3, 0), (20.0, 1, 0)]).as_bytes());
    let found = folder.json("fit probability a=a.json b=b.json");
    let odds = found["log_odds"].as_array().unwrap();
    // By hand: even odds at 50 nats, 4 : 1 at 90.
    assert!((number(&odds[0]) + number(&odds[1]) * 50.0).abs() < 1e-3, "{odds:?}");
    assert!((number(&odds[1]) - 4_f64.ln() / 40.0).abs() < 1e-4, "{odds:?}");
    let row = &found["cross_validated"][2];
    assert_eq!((number(&row["right"]), number(&row["wrong"])), (16.0, 4.0), "at 0.8: {row}");
    // On a foreign plan nothing is right, wherever it is found.
    let foreign = folder.json("fit probability a=a.json b=b.json --foreign b=c.json");
    assert_eq!((number(&foreign["answers"]), number(&foreign["foreign_answers"])), (50.0, 4.0));
    assert!(number(&foreign["log_odds"][0]) < number(&odds[0]));
}

#[test]
fn what_cannot_be_fitted_is_said() {
    let folder = Folder::new();
    folder.write("a.json", result(&[(10.0, 0, 5), (90.0, 5, 0)]).as_bytes());
    folder.write("bad.json", b"[]");
    for (line, why) in [
        ("fit probability a=a.json", "one building alone"),
        ("fit probability a=a.json b=a.json", "a lead tells them apart"),
        ("fit probability a.json b=a.json", "is not BUILDING=RESULT"),
        ("fit probability a=none.json b=a.json", "none.json: cannot be read"),
        ("fit probability a=bad.json b=a.json", "bad.json: not a result of evaluate"),
    ] {
        let ran = folder.run(line);
        assert!(ran.status == Some(2) && ran.stderr.contains(why), "{line}: {}", ran.stderr);
    }
}
