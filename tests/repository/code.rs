//! What the files of the crate name of one another, read from their code.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Names from the crate's root on.
pub(crate) type ModulePath = Vec<String>;

/// A file's code, as words and signs.
pub(crate) struct Source {
    /// Below src, with `/`.
    pub(crate) name: String,
    pub(crate) tokens: Vec<String>,
}

/// What a file names, tests aside.
#[derive(Default)]
pub(crate) struct Names {
    /// Paths as they are written, from the crate's root on where they are relative to it.
    pub(crate) paths: Vec<ModulePath>,
    /// What is passed on to others, under which name; `*` for all that there is.
    passed_on: Vec<(String, ModulePath)>,
}

/// All files of the crate by their modules.
pub(crate) struct Crate {
    pub(crate) sources: BTreeMap<ModulePath, Source>,
    names: BTreeMap<ModulePath, Names>,
}

fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphanumeric() || c == '_')
}

/// Words and signs of a code, without comments, strings and characters.
pub(crate) fn tokens(code: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = code;
    let after = |text: &'_ str, end: &str| text.find(end).map_or(text.len(), |at| at + end.len());
    while let Some(first) = rest.chars().next() {
        let hashes = rest.strip_prefix('r').map(|raw| raw.len() - raw.trim_start_matches('#').len());
        let raw = hashes.filter(|&n| rest[1 + n..].starts_with('"'));
        let character = rest.strip_prefix('\'').and_then(|inner| {
            let close = match inner.strip_prefix('\\') {
                // What is escaped may be a quote itself.
                Some(_) => 2 + inner.get(2..)?.find('\'')?,
                None => inner.chars().next()?.len_utf8(),
            };
            // Others are lifetimes.
            inner[close..].starts_with('\'').then_some(close + 2)
        });
        let length = if rest.starts_with("//") {
            after(rest, "\n")
        } else if rest.starts_with("/*") {
            after(rest, "*/")
        } else if let Some(hashes) = raw {
            let begin = hashes + 2;
            begin + after(&rest[begin..], &format!("\"{}", "#".repeat(hashes)))
        } else if first == '"' {
            let mut escaped = false;
            let end = rest[1..].find(|c| {
                let is_end = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                is_end
            });
            end.map_or(rest.len(), |at| at + 2)
        } else if let Some(length) = character {
            length
        } else {
            let word = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
            let length = if word > 0 { word } else { first.len_utf8() };
            let length = if rest.starts_with("::") { 2 } else { length };
            if !first.is_whitespace() {
                tokens.push(rest[..length].to_owned());
            }
            length
        };
        rest = &rest[length..];
    }
    tokens
}

/// The index behind the bracket that closes the one at `open`.
fn behind(tokens: &[String], open: usize) -> usize {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        match token.as_str() {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return i + 1;
        }
    }
    tokens.len()
}

/// The code without what only tests see, and without who may see what.
fn without_tests(tokens: &[String]) -> Vec<String> {
    let mut kept = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        let is = |offset: usize, text: &str| tokens.get(i + offset).is_some_and(|t| t == text);
        if is(0, "#") && is(1, "[") {
            let mut end = behind(tokens, i + 1);
            let attribute = &tokens[i..end];
            let has = |word: &str| attribute.iter().any(|t| t == word);
            if is(2, "cfg") && has("test") && !has("not") {
                // Up to the end of the item that it stands before.
                while !matches!(tokens.get(end).map(String::as_str), None | Some("{" | ";")) {
                    end += 1;
                }
                end = if tokens.get(end).is_some_and(|t| t == "{") { behind(tokens, end) } else { end + 1 };
            }
            i = end;
        } else if is(0, "pub") && is(1, "(") {
            kept.push("pub".to_owned());
            i = behind(tokens, i + 1);
        } else {
            kept.push(tokens[i].clone());
            i += 1;
        }
    }
    kept
}

/// The paths of a tree of `use`, each with the name that it gets.
fn of_tree(tokens: &[String], before: &[String], found: &mut Vec<(String, ModulePath)>) {
    let mut path = before.to_vec();
    let mut i = 0;
    while i < tokens.len() {
        match tokens[i].as_str() {
            "{" => {
                let end = behind(tokens, i) - 1;
                let (mut start, mut at) = (i + 1, i + 1);
                while at <= end {
                    if at == end || tokens[at] == "," {
                        if at > start {
                            of_tree(&tokens[start..at], &path, found);
                        }
                        start = at + 1;
                    }
                    at = if tokens[at] == "{" { behind(tokens, at) } else { at + 1 };
                }
                return;
            }
            "::" => i += 1,
            "as" => {
                found.push((tokens.get(i + 1).cloned().unwrap_or_default(), path));
                return;
            }
            word => {
                path.push(word.to_owned());
                i += 1;
            }
        }
    }
    // The module itself.
    if path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    found.push((path.last().cloned().unwrap_or_default(), path));
}

impl Names {
    fn of(tokens: &[String]) -> Self {
        let tokens = without_tests(tokens);
        let mut names = Self::default();
        let mut words = BTreeSet::new();
        let mut i = 0;
        while i < tokens.len() {
            if is_word(&tokens[i]) && !(i > 0 && tokens[i - 1] == "mod") {
                words.insert(tokens[i].as_str());
            }
            let is = |at: usize, text: &str| tokens.get(at).is_some_and(|t| t == text);
            if is(i, "use") && (i == 0 || [";", "}", "{", "pub"].contains(&tokens[i - 1].as_str())) {
                let end = (i..tokens.len()).find(|&at| tokens[at] == ";").unwrap_or(tokens.len());
                let mut found = Vec::new();
                of_tree(&tokens[i + 1..end], &[], &mut found);
                if i > 0 && is(i - 1, "pub") {
                    names.passed_on.extend(found);
                } else {
                    names.paths.extend(found.into_iter().map(|(_, path)| path));
                }
                i = end;
            } else if is_word(&tokens[i])
                && is(i + 1, "::")
                && !(i > 0 && [".", "::"].contains(&tokens[i - 1].as_str()))
            {
                let mut path = vec![tokens[i].clone()];
                while is(i + 1, "::") && tokens.get(i + 2).is_some_and(|t| is_word(t)) {
                    path.push(tokens[i + 2].clone());
                    i += 2;
                }
                names.paths.push(path);
                i += 1;
            } else {
                i += 1;
            }
        }
        // What is passed on may be used, too.
        let used = names.passed_on.iter().filter(|(name, _)| words.contains(name.as_str()));
        names.paths.extend(used.map(|(_, path)| path.clone()));
        names
    }
}

impl Crate {
    pub(crate) fn read(root: &Path) -> Self {
        let mut sources = BTreeMap::new();
        let mut folders = vec![root.to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|e| e == "rs") {
                    let name = path.strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/");
                    let tokens = tokens(&fs::read_to_string(&path).unwrap());
                    let stem = name.trim_end_matches(".rs").trim_end_matches("/mod");
                    let module = stem.split('/').map(str::to_owned).collect();
                    sources.insert(module, Source { name, tokens });
                }
            }
        }
        Self::of(sources)
    }

    fn of(sources: BTreeMap<ModulePath, Source>) -> Self {
        let names = sources.iter().map(|(module, s)| (module.clone(), Names::of(&s.tokens))).collect();
        Self { sources, names }
    }

    /// The path from the crate's root on; `None` where it leads out of the crate, or to
    /// something of the file's own.
    fn absolute(&self, module: &[String], path: &[String]) -> Option<ModulePath> {
        let mut base = module.to_vec();
        let rest = match path.first()?.as_str() {
            "crate" => {
                base.clear();
                &path[1..]
            }
            "self" => &path[1..],
            "super" => {
                let up = path.iter().take_while(|part| *part == "super").count();
                base.truncate(base.len().checked_sub(up)?);
                &path[up..]
            }
            first => {
                base.push(first.to_owned());
                let is_child = self.sources.contains_key(&base);
                base.pop();
                is_child.then_some(path)?
            }
        };
        Some(base.into_iter().chain(rest.iter().cloned()).collect())
    }

    /// The file that what a path from the root names is in, whoever passes it on.
    fn home(&self, path: &[String], depth: usize) -> Option<ModulePath> {
        let known = (1..=path.len()).rev().find(|&n| self.sources.contains_key(&path[..n]))?;
        let (module, rest) = path.split_at(known);
        // A path that leads on in a circle is left where it is.
        if let Some(name) = rest.first().filter(|_| depth < 16) {
            for (passed, from) in &self.names[module].passed_on {
                if passed == name || passed == "*" {
                    let Some(mut on) = self.absolute(module, from) else { continue };
                    if passed == "*" {
                        on.pop();
                        on.push(name.clone());
                    }
                    on.extend(rest[1..].iter().cloned());
                    if passed == name || self.names.contains_key(&on) {
                        return self.home(&on, depth + 1);
                    }
                }
            }
        }
        Some(module.to_vec())
    }

    /// The paths from the root on that a file names.
    pub(crate) fn named(&self, module: &[String]) -> impl Iterator<Item = ModulePath> {
        let names = &self.names[module];
        let all = names.paths.iter().chain(names.passed_on.iter().map(|(_, path)| path));
        all.filter_map(|path| self.absolute(module, path))
    }

    /// The other files of the same module whose things a file uses. What it only passes on
    /// is no use.
    fn used(&self, module: &[String]) -> BTreeSet<ModulePath> {
        let paths = self.names[module].paths.iter().filter_map(|path| self.absolute(module, path));
        let homes = paths.filter_map(|path| self.home(&path, 0));
        homes.filter(|home| home[0] == module[0] && home != module).collect()
    }

    /// Files of a module that use one another, in the order in which they do.
    pub(crate) fn circle(&self, top: &str) -> Option<Vec<ModulePath>> {
        let is_meant = |module: &&ModulePath| module[0] == top && !module.iter().any(|part| part == "tests");
        let uses: BTreeMap<&ModulePath, BTreeSet<ModulePath>> =
            self.sources.keys().filter(is_meant).map(|module| (module, self.used(module))).collect();
        let mut done = BTreeSet::new();
        uses.keys().find_map(|module| walk(module, &uses, &mut Vec::new(), &mut done))
    }
}

/// Goes on along what is used until it comes to where it has been.
fn walk(
    module: &ModulePath,
    uses: &BTreeMap<&ModulePath, BTreeSet<ModulePath>>,
    way: &mut Vec<ModulePath>,
    done: &mut BTreeSet<ModulePath>,
) -> Option<Vec<ModulePath>> {
    if let Some(at) = way.iter().position(|been| been == module) {
        return Some(way[at..].to_vec());
    }
    if done.contains(module) {
        return None;
    }
    way.push(module.clone());
    let circle = uses.get(module).into_iter().flatten().find_map(|next| walk(next, uses, way, done));
    way.pop();
    done.insert(module.clone());
    circle
}

/// Crates that are named as the start of a path.
pub(crate) fn names_crate(tokens: &[String], name: &str) -> bool {
    (0..tokens.len()).filter(|&i| tokens[i] == name).any(|i| {
        let before = i.checked_sub(1).map_or("", |i| tokens[i].as_str());
        let after = tokens.get(i + 1).map_or("", String::as_str);
        ![".", "::"].contains(&before) && (after == "::" || before == "use")
    })
}

#[test]
fn the_reader_of_paths_sees_what_there_is() {
    let text = r##"
use crate::geometry::{SampleCloud, TriMesh};
use crate::{io::{self, Shape}, worker as w};
pub(in crate::ui) fn f(c: char) -> bool { super::helper(); crate::session::x(c == '"') } // crate::app
const S: &str = "crate::ui \" {"; const R: &str = r#"crate::app " }"#; /* crate::app */
#[cfg(test)]
mod tests { use super::*; use crate::cli; }
"##;
    let paths: Vec<String> = Names::of(&tokens(text)).paths.iter().map(|path| path.join("::")).collect();
    assert_eq!(
        paths,
        [
            "crate::geometry::SampleCloud",
            "crate::geometry::TriMesh",
            "crate::io",
            "crate::io::Shape",
            "crate::worker",
            "super::helper",
            "crate::session::x"
        ]
    );
    let names = |text: &str, name: &str| names_crate(&tokens(text), name);
    assert!(names("use egui;", "egui") && names("x: wgpu::Device", "wgpu"));
    assert!(!names("egui_wgpu::Callback", "wgpu") && !names("eframe::wgpu::Device", "wgpu"));
}

#[test]
fn circles_are_found_also_through_what_is_passed_on() {
    let circle = |files: &[(&str, &str)]| {
        let source = |(name, code): &(&str, &str)| {
            let module = name.split('/').map(str::to_owned).collect();
            (module, Source { name: (*name).to_owned(), tokens: tokens(code) })
        };
        let circle = Crate::of(files.iter().map(source).collect()).circle("m");
        circle.map(|circle| circle.iter().map(|module| module.join("/")).collect::<Vec<_>>())
    };
    // A parent that only passes on is nobody's business.
    let (parent, a) = (("m", "mod a; mod b; pub use a::A; pub(crate) use b::*;"), ("m/a", "pub struct A;"));
    assert_eq!(circle(&[parent, a, ("m/b", "use super::A; pub struct B;")]), None);
    let both = circle(&[parent, ("m/a", "use crate::m::b::B; pub struct A;"), ("m/b", "use super::A;")]);
    assert_eq!(both.unwrap(), ["m/a", "m/b"]);
    let parent = ("m", "mod a; fn helper() { a::act() }");
    assert_eq!(circle(&[parent, ("m/a", "pub fn act() { super::helper() }")]).unwrap(), ["m", "m/a"]);
    let parent = ("m", "mod a; pub use a::A; pub struct B(A);");
    assert_eq!(circle(&[parent, ("m/a", "pub struct A(Option<Box<super::B>>);")]).unwrap(), ["m", "m/a"]);
    let itself = ("m", "mod a; #[cfg(test)] mod t { use super::a; } fn helper() {}");
    assert_eq!(circle(&[itself, ("m/a", "pub fn act() { super::helper() }")]), None);
}
