//! The import graph: a wing of the core imports only earlier wings, a module of core or host only earlier ones; no
//! cycles.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Wings of `compass-core` in their order: none imports from one after it.
const WINGS: [&str; 6] = ["base", "map", "vision", "pose", "descriptor", "locator"];

/// Modules by path (`vision::segments::draw`) with the modules they import from.
type Graph = BTreeMap<String, BTreeSet<String>>;

/// The source files of a crate as modules and text without its tests.
fn modules(root: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let name = module_of(root, &path);
                if !name.ends_with("tests") {
                    found.insert(name, without_tests(&std::fs::read_to_string(&path).unwrap()));
                }
            }
        }
    }
    found
}

/// `src/vision/segments/draw.rs` is `vision::segments::draw`, `src/vision/mod.rs` is `vision`; the root has no name.
fn module_of(root: &Path, path: &Path) -> String {
    let relative: PathBuf = path.strip_prefix(root).unwrap().with_extension("");
    let parts = relative.iter().map(|part| part.to_str().unwrap());
    parts.filter(|part| !["mod", "lib"].contains(part)).collect::<Vec<_>>().join("::")
}

/// Removes the test module at the end, comments, and re-exports: a facade does not depend on what it re-exports.
fn without_tests(text: &str) -> String {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code = lines.collect::<Vec<_>>().join("\n");
    let statements = code.split_inclusive(';');
    statements.filter(|s| !s.trim_start().starts_with("pub use") && !s.contains("#[cfg(doc)]")).collect()
}

/// Every path that begins with `crate::` or `super::` in a module's text, with brace groups expanded.
fn imports(module: &str, text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for root in ["crate::", "super::"] {
        for (at, _) in text.match_indices(root) {
            let before = text[..at].chars().next_back();
            // `pub(in crate::...)` imports nothing.
            let is_visibility = text[..at].ends_with("pub(in ");
            if is_visibility || before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            let mut names = Vec::new();
            expand(&text[at..], "", &mut names);
            found.extend(names.into_iter().map(|name| absolute(module, &name)));
        }
    }
    found
}

/// Parses one path, with its groups, off the front of a text; returns the rest.
fn expand<'t>(text: &'t str, prefix: &str, found: &mut Vec<String>) -> &'t str {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(text.len());
    let path = format!("{prefix}{}", &text[..end]);
    let mut rest = &text[end..];
    if !path.ends_with("::") || !rest.starts_with('{') {
        found.push(path.trim_end_matches(':').to_owned());
        return rest;
    }
    rest = &rest[1..];
    loop {
        rest = expand(rest.trim_start(), &path, found).trim_start();
        match rest.strip_prefix(',') {
            Some(more) if !more.trim_start().starts_with('}') => rest = more,
            _ => break,
        }
    }
    rest.trim_start_matches([',', ' ', '\n', '\t']).strip_prefix('}').unwrap_or(rest)
}

/// Resolves a `crate::` or `super::` path of a module against the root.
fn absolute(module: &str, path: &str) -> String {
    let mut scope: Vec<&str> = module.split("::").filter(|part| !part.is_empty()).collect();
    let mut parts: Vec<&str> = path.split("::").collect();
    if parts.first() == Some(&"crate") {
        scope.clear();
        parts.remove(0);
    }
    while parts.first() == Some(&"super") {
        scope.pop();
        parts.remove(0);
    }
    scope.into_iter().chain(parts).collect::<Vec<_>>().join("::")
}

/// The graph of a crate: each import goes to the longest module that begins its path.
fn graph(modules: &BTreeMap<String, String>) -> Graph {
    let owner = |path: &str| {
        let parts: Vec<_> = path.split("::").collect();
        let prefixes = (1..=parts.len()).rev().map(|length| parts[..length].join("::"));
        prefixes.into_iter().find(|prefix| modules.contains_key(prefix))
    };
    let edges = |(module, text): (&String, &String)| {
        let mut targets: BTreeSet<_> = imports(module, text).iter().filter_map(|path| owner(path)).collect();
        targets.extend(
            children(module, modules).filter(|child| names(text, child)).map(|child| below(module, child)),
        );
        targets.remove(module);
        (module.clone(), targets)
    };
    modules.iter().map(edges).collect()
}

/// The names of a module's own children.
fn children<'m>(module: &str, modules: &'m BTreeMap<String, String>) -> impl Iterator<Item = &'m str> {
    let prefix = below(module, "");
    let child = move |name: &'m String| {
        name.strip_prefix(&prefix).filter(|rest| !rest.is_empty() && !rest.contains("::"))
    };
    modules.keys().filter_map(child)
}

fn below(module: &str, child: &str) -> String {
    if module.is_empty() { child.to_owned() } else { format!("{module}::{child}") }
}

/// Whether a text has a path that begins with the name of a child.
fn names(text: &str, child: &str) -> bool {
    let start = format!("{child}::");
    text.match_indices(&start).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':')
    })
}

/// Imports of a wing from a later one, as text.
fn arrows_upwards(graph: &Graph) -> Vec<String> {
    let wing = |module: &str| {
        let first = module.split("::").next().unwrap_or_default();
        WINGS.iter().position(|wing| *wing == first)
    };
    let mut found = Vec::new();
    for (module, targets) in graph {
        for target in targets {
            if let (Some(from), Some(to)) = (wing(module), wing(target))
                && to > from
            {
                found.push(format!("{module} imports {target}"));
            }
        }
    }
    found
}

/// Import cycles, as text; one for each module that closes one.
fn circles(graph: &Graph) -> Vec<String> {
    fn visit(
        module: &str,
        graph: &Graph,
        path: &mut Vec<String>,
        done: &mut BTreeSet<String>,
        found: &mut Vec<String>,
    ) {
        if let Some(start) = path.iter().position(|on| on == module) {
            found.push(format!("{} -> {module}", path[start..].join(" -> ")));
            return;
        }
        if !done.contains(module) {
            path.push(module.to_owned());
            for target in graph.get(module).into_iter().flatten() {
                visit(target, graph, path, done, found);
            }
            path.pop();
            done.insert(module.to_owned());
        }
    }
    let (mut done, mut found) = (BTreeSet::new(), Vec::new());
    for module in graph.keys() {
        visit(module, graph, &mut Vec::new(), &mut done, &mut found);
    }
    found
}

fn source(krate: &str) -> BTreeMap<String, String> {
    modules(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(krate).join("src"))
}

#[test]
fn wings_know_those_above_them_alone() {
    let graph = graph(&source("compass-core"));
    assert!(WINGS.iter().all(|wing| graph.keys().any(|module| module.starts_with(wing))));
    let arrows = arrows_upwards(&graph);
    assert!(arrows.is_empty(), "{arrows:#?}");
}

#[test]
fn no_circle_of_modules() {
    for krate in ["compass-core", "compass-host"] {
        let circles = circles(&graph(&source(krate)));
        assert!(circles.is_empty(), "{krate}: {circles:#?}");
    }
}

#[test]
fn planted_arrows_and_circles_are_found() {
    let mut modules = source("compass-core");
    let plan = modules.get_mut("map::plan").unwrap();
    plan.push_str("\nuse crate::{base::num::Turn, pose::track::{Motion, Track}};\n");
    let arrows = arrows_upwards(&graph(&modules));
    assert_eq!(arrows, ["map::plan imports pose::track"]);
    assert!(!circles(&graph(&modules)).is_empty(), "the track needs plans");
    let mut modules = source("compass-host");
    modules.get_mut("frame").unwrap().push_str("\nuse crate::locator::Locator;\n");
    assert!(circles(&graph(&modules)).iter().any(|circle| circle.contains("frame")));
}

#[test]
fn groups_are_spelled_out() {
    let text = "use crate::{a::{B, c::D}, e};\nuse super::f::G;\nlet x = crate::h::i();";
    let found = imports("w::m", text);
    let expected = ["a::B", "a::c::D", "e", "h::i", "w::f::G"];
    assert_eq!(found.iter().map(String::as_str).collect::<Vec<_>>(), expected);
}
