//! The tree of modules of a crate, as rustc builds it from the `mod` declarations.

use std::collections::{BTreeMap, BTreeSet};

use syn::visit::{self, Visit};
use syn::{Expr, Item, ItemMod, ItemUse, Lit, Meta, UseTree, Visibility};

use super::attributes::is_test;

/// The Rust files of a crate: path from `src` on, with forward slashes, and text.
pub(super) type Sources = BTreeMap<String, String>;

/// A module: a file, or `mod name { .. }` within one.
pub(super) struct Module {
    /// The file that its items stand in, as [`Sources`] names it.
    pub(super) file: String,
    pub(super) parent: Option<usize>,
    /// Its child modules, by name.
    pub(super) modules: BTreeMap<String, usize>,
    /// The names of the items that it defines.
    pub(super) items: BTreeSet<String>,
    pub(super) imports: Vec<Import>,
    /// Whether it calls a macro where items stand, which may define more of them.
    pub(super) makes_items: bool,
}

/// A name that a `use` brings into a module.
pub(super) struct Import {
    /// The name here, `*` for a glob.
    pub(super) name: String,
    /// The path there, without the `*`.
    pub(super) path: Vec<String>,
    /// Whether others see it here.
    pub(super) is_reexport: bool,
}

/// The modules of a crate. A package with a library and a program has a root for each.
#[derive(Default)]
pub(super) struct Tree {
    pub(super) modules: Vec<Module>,
    /// The syntax of each file that is a module, with the module's number.
    pub(super) files: BTreeMap<String, (usize, syn::File)>,
    /// The macros defined by `macro_rules!`, whose names reach across modules: name and module.
    pub(super) macros: Vec<(String, usize)>,
    /// Files that are modules in tests only.
    pub(super) test_files: BTreeSet<String>,
}

/// Whether the file is the root of a crate rather than a module in one.
pub(super) fn is_root(file: &str) -> bool {
    file == "lib.rs" || file == "main.rs" || (file.starts_with("bin/") && file.matches('/').count() == 1)
}

impl Tree {
    /// Reads every file that a root leads to.
    pub(super) fn new(sources: &Sources) -> Result<Self, String> {
        let mut tree = Self::default();
        for root in sources.keys().filter(|file| is_root(file)) {
            let folder = root.rsplit_once('/').map_or("", |(folder, _)| folder);
            tree.add_file(sources, root, folder, None)?;
        }
        Ok(tree)
    }

    /// The module and the one that holds it, and so on up to the root.
    pub(super) fn ancestors(&self, module: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(module), |&module| self.modules[module].parent)
    }

    fn add_file(
        &mut self,
        sources: &Sources,
        file: &str,
        folder: &str,
        parent: Option<usize>,
    ) -> Result<usize, String> {
        let text = sources.get(file).ok_or_else(|| format!("{file} is declared as a module, but is not there"))?;
        let syntax = syn::parse_file(text).map_err(|error| format!("{file} cannot be parsed: {error}"))?;
        let module = self.add_module(file, parent);
        self.add_items(sources, module, folder, &syntax.items)?;
        self.files.insert(file.into(), (module, syntax));
        Ok(module)
    }

    fn add_module(&mut self, file: &str, parent: Option<usize>) -> usize {
        self.modules.push(Module {
            file: file.into(),
            parent,
            modules: BTreeMap::new(),
            items: BTreeSet::new(),
            imports: Vec::new(),
            makes_items: false,
        });
        self.modules.len() - 1
    }

    /// Enters the items of a module whose child modules lie in this folder.
    fn add_items(&mut self, sources: &Sources, module: usize, folder: &str, items: &[Item]) -> Result<(), String> {
        for item in items {
            if let Item::Mod(child) = item {
                self.add_child(sources, module, folder, child)?;
            } else if !is_test(attributes(item)) {
                self.add_item(module, item);
            }
        }
        Ok(())
    }

    fn add_child(&mut self, sources: &Sources, module: usize, folder: &str, child: &ItemMod) -> Result<(), String> {
        let name = plain(&child.ident);
        let inner_folder = join(folder, &name);
        let number = if let Some((_, items)) = &child.content {
            if is_test(&child.attrs) {
                self.mark_tests(sources, &inner_folder, items);
                return Ok(());
            }
            let number = self.add_module(&self.modules[module].file.clone(), Some(module));
            self.add_items(sources, number, &inner_folder, items)?;
            number
        } else {
            let here = &self.modules[module].file;
            let file = child_file(sources, here, folder, child);
            let own_folder = if file.ends_with("/mod.rs") {
                file.trim_end_matches("/mod.rs").to_string()
            } else {
                file.trim_end_matches(".rs").to_string()
            };
            let for_tests = sources.get(&file).and_then(|text| syn::parse_file(text).ok());
            if let Some(syntax) = for_tests.filter(|syntax| is_test(&child.attrs) || is_test(&syntax.attrs)) {
                self.test_files.insert(file);
                self.mark_tests(sources, &own_folder, &syntax.items);
                return Ok(());
            }
            self.add_file(sources, &file, &own_folder, Some(module))?
        };
        self.modules[module].modules.insert(name, number);
        Ok(())
    }

    /// Marks the files that only tests reach.
    fn mark_tests(&mut self, sources: &Sources, folder: &str, items: &[Item]) {
        for item in items {
            let Item::Mod(child) = item else { continue };
            if let Some((_, items)) = &child.content {
                self.mark_tests(sources, &join(folder, &plain(&child.ident)), items);
                continue;
            }
            let file = child_file(sources, "", folder, child);
            let inside = sources.get(&file).and_then(|text| syn::parse_file(text).ok());
            self.test_files.insert(file.clone());
            if let Some(syntax) = inside {
                let own_folder = file.trim_end_matches("/mod.rs").trim_end_matches(".rs").to_string();
                self.mark_tests(sources, &own_folder, &syntax.items);
            }
        }
    }

    fn add_item(&mut self, module: usize, item: &Item) {
        if let Item::Use(import) = item {
            self.modules[module].imports.extend(imports(import));
            return;
        }
        if let Item::Macro(call) = item {
            match &call.ident {
                Some(name) => self.macros.push((plain(name), module)),
                None => self.modules[module].makes_items = true,
            }
        }
        self.modules[module].items.extend(name(item));
        let mut inner = InnerUses::default();
        inner.visit_item(item);
        self.modules[module].imports.extend(inner.imports);
    }
}

/// The `use`s within functions. They count for the whole module: names are seldom given twice.
#[derive(Default)]
struct InnerUses {
    imports: Vec<Import>,
}

impl Visit<'_> for InnerUses {
    fn visit_item(&mut self, item: &Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &ItemUse) {
        self.imports.extend(imports(item));
    }
}

/// The names that a `use` brings in; none for one that starts with `::`, which leads out of the crate.
pub(super) fn imports(item: &ItemUse) -> Vec<Import> {
    fn walk(tree: &UseTree, path: &mut Vec<String>, is_reexport: bool, found: &mut Vec<Import>) {
        let import = |name: String, path: Vec<String>| Import { name, path, is_reexport };
        match tree {
            UseTree::Path(step) => {
                path.push(plain(&step.ident));
                walk(&step.tree, path, is_reexport, found);
                path.pop();
            }
            UseTree::Name(last) => {
                let last = plain(&last.ident);
                let name = if last == "self" { path.last().cloned().unwrap_or_default() } else { last.clone() };
                found.push(import(name, [&path[..], &[last]].concat()));
            }
            UseTree::Rename(last) => {
                found.push(import(plain(&last.rename), [&path[..], &[plain(&last.ident)]].concat()));
            }
            UseTree::Glob(_) => found.push(import("*".into(), path.clone())),
            UseTree::Group(group) => group.items.iter().for_each(|tree| walk(tree, path, is_reexport, found)),
        }
    }
    let mut found = Vec::new();
    if item.leading_colon.is_none() {
        walk(&item.tree, &mut Vec::new(), !matches!(item.vis, Visibility::Inherited), &mut found);
    }
    found
}

/// The name without `r#`.
pub(super) fn plain(name: &syn::Ident) -> String {
    name.to_string().trim_start_matches("r#").into()
}

/// The file of `mod child;` that stands in the file `here`, whose child modules lie in the folder.
fn child_file(sources: &Sources, here: &str, folder: &str, child: &ItemMod) -> String {
    let given = child.attrs.iter().find(|attribute| attribute.path().is_ident("path")).map(|attribute| &attribute.meta);
    if let Some(Meta::NameValue(pair)) = given
        && let Expr::Lit(literal) = &pair.value
        && let Lit::Str(path) = &literal.lit
    {
        return join(here.rsplit_once('/').map_or("", |(folder, _)| folder), &path.value());
    }
    let beside = join(folder, &plain(&child.ident));
    let in_folder = format!("{beside}/mod.rs");
    if sources.contains_key(&in_folder) { in_folder } else { format!("{beside}.rs") }
}

fn join(folder: &str, name: &str) -> String {
    if folder.is_empty() { name.into() } else { format!("{folder}/{name}") }
}

/// The name that an item defines.
fn name(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::TraitAlias(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(plain(ident))
}

/// The attributes of an item, as far as `cfg` can stand there.
pub(super) fn attributes(item: &Item) -> &[syn::Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}
