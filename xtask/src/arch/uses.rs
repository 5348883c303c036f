//! The arrows between the files of a crate: the names that each file takes from others.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{
    Arm, Attribute, Expr, ExprPath, Field, FieldValue, ImplItem, Item, ItemMod, ItemUse, Local, Macro, Meta, PatIdent,
    Path, StmtMacro, TraitItem, Variant,
};

use super::attributes::is_test;
use super::modules::{Sources, Tree, attributes, imports, plain};
use super::resolve::Meaning;

/// The names that one file takes from another, by user and used.
pub(super) type Arrows = BTreeMap<(String, String), BTreeSet<String>>;

/// The arrows, modules and faults of a crate's source.
pub(super) struct Code {
    pub(super) arrows: Arrows,
    /// The number of files read.
    pub(super) files: usize,
    /// The files that hold modules, without those of tests.
    pub(super) modules: BTreeSet<String>,
    /// Paths that lead nowhere, and files that nothing declares.
    pub(super) faults: Vec<String>,
}

/// Reads the crate.
pub(super) fn code(sources: &Sources) -> Result<Code, String> {
    let tree = Tree::new(sources)?;
    let mut arrows = Arrows::new();
    let mut lost = BTreeSet::new();
    for (module, syntax) in tree.files.values() {
        let mut walk =
            Walk { tree: &tree, module: *module, bound: bound(syntax), arrows: &mut arrows, lost: &mut lost };
        walk.visit_file(syntax);
    }
    let undeclared = sources.keys().filter(|file| !tree.files.contains_key(*file) && !tree.test_files.contains(*file));
    let mut faults: Vec<String> = undeclared.map(|file| format!("no module declares {file}")).collect();
    faults.extend(lost);
    Ok(Code { arrows, files: tree.files.len(), modules: tree.files.into_keys().collect(), faults })
}

/// The names of the variables of a file. An expression of one of these names is taken for the variable.
fn bound(syntax: &syn::File) -> BTreeSet<String> {
    struct Variables(BTreeSet<String>);
    impl Visit<'_> for Variables {
        fn visit_pat_ident(&mut self, pattern: &PatIdent) {
            if is_variable(pattern) {
                self.0.insert(plain(&pattern.ident));
            }
            visit::visit_pat_ident(self, pattern);
        }
    }
    let mut variables = Variables(BTreeSet::new());
    variables.visit_file(syntax);
    variables.0
}

/// A pattern in capitals compares with a constant or a variant.
fn is_variable(pattern: &PatIdent) -> bool {
    !pattern.ident.to_string().starts_with(char::is_uppercase)
}

/// A visitor of the code of a file.
struct Walk<'a> {
    tree: &'a Tree,
    module: usize,
    bound: BTreeSet<String>,
    arrows: &'a mut Arrows,
    lost: &'a mut BTreeSet<String>,
}

impl Walk<'_> {
    fn file(&self, module: usize) -> &str {
        &self.tree.modules[module].file
    }

    fn add(&mut self, meanings: &[Meaning]) {
        for meaning in meanings {
            if let Meaning::Item(module, name) = meaning
                && self.file(*module) != self.file(self.module)
            {
                let arrow = (self.file(self.module).to_string(), self.file(*module).to_string());
                self.arrows.entry(arrow).or_default().insert(name.clone());
            }
        }
    }

    /// A path that stands in the code itself, so that one into this crate has to lead somewhere.
    fn path(&mut self, path: &[String]) {
        let meanings = self.tree.resolve(self.module, path);
        if meanings.is_empty() && path.len() > 1 && matches!(path[0].as_str(), "crate" | "self" | "super") {
            self.lost.insert(format!("{}: {} leads to nothing that is known", self.file(self.module), path.join("::")));
        }
        self.add(&meanings);
    }

    /// A path found in the tokens of a macro, where it may be part of a longer one.
    fn token_path(&mut self, path: &[String]) {
        let is_variable = path.len() == 1 && self.bound.contains(&path[0]);
        if !is_variable {
            self.add(&self.tree.resolve(self.module, path));
        }
    }

    /// The paths in tokens: names joined by `::`, but not those behind a dot.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        // The number of colons since the last name; a dot before a name makes it a method or a field.
        let (mut colons, mut after_dot) = (0, false);
        for token in tokens {
            let is_dot = matches!(&token, TokenTree::Punct(mark) if mark.as_char() == '.');
            match token {
                TokenTree::Ident(name) if after_dot => drop(name),
                TokenTree::Ident(name) => {
                    if colons != 2 {
                        self.token_path(&std::mem::take(&mut path));
                    }
                    path.push(plain(&name));
                    colons = 0;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
                TokenTree::Group(group) => {
                    self.token_path(&std::mem::take(&mut path));
                    self.tokens(group.stream());
                }
                TokenTree::Literal(literal) => self.quoted(&literal.to_string()),
                TokenTree::Punct(_) => self.token_path(&std::mem::take(&mut path)),
            }
            after_dot = is_dot;
        }
        self.token_path(&path);
    }

    /// A path in quotes, as attributes of serde have them.
    fn quoted(&mut self, literal: &str) {
        let text = literal.trim_matches('"');
        if text.contains("::") && !text.contains(char::is_whitespace) {
            let path: Vec<String> = text.split("::").map(Into::into).collect();
            self.token_path(&path);
        }
    }

    /// A macro called by its mere name: one of `macro_rules!`, which needs no import.
    fn macro_by_name(&mut self, name: &str) {
        let file = self.file(self.module);
        let of_name: Vec<usize> = self.tree.macros.iter().filter(|(known, _)| known == name).map(|&(_, m)| m).collect();
        if self.tree.resolve(self.module, &[name.into()]).is_empty()
            && !of_name.iter().any(|&module| self.file(module) == file)
        {
            let meanings: Vec<Meaning> = of_name.into_iter().map(|module| Meaning::Item(module, name.into())).collect();
            self.add(&meanings);
        }
    }
}

impl Visit<'_> for Walk<'_> {
    fn visit_item(&mut self, item: &Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &ItemMod) {
        let Some((_, items)) = &item.content else { return };
        let Some(&inner) = self.tree.modules[self.module].modules.get(&plain(&item.ident)) else { return };
        let outer = std::mem::replace(&mut self.module, inner);
        for item in items {
            self.visit_item(item);
        }
        self.module = outer;
    }

    /// A module that hands on what stands below it does not use it; what is handed on from elsewhere is used. What a
    /// glob brings counts where it is named.
    fn visit_item_use(&mut self, item: &ItemUse) {
        for import in imports(item) {
            if import.name == "*" {
                let meanings = self.tree.resolve(self.module, &import.path);
                self.add(&meanings);
            } else if import.is_reexport {
                let mut meanings = self.tree.resolve(self.module, &import.path);
                meanings.retain(|meaning| {
                    matches!(meaning, Meaning::Item(module, _)
                        if !self.tree.ancestors(*module).any(|ancestor| ancestor == self.module))
                });
                self.add(&meanings);
            } else {
                self.path(&import.path);
            }
        }
    }

    fn visit_path(&mut self, path: &Path) {
        if path.leading_colon.is_none() {
            let names: Vec<String> = path.segments.iter().map(|segment| plain(&segment.ident)).collect();
            self.path(&names);
        }
        visit::visit_path(self, path);
    }

    fn visit_expr_path(&mut self, expression: &ExprPath) {
        if !expression.path.get_ident().is_some_and(|name| self.bound.contains(&plain(name))) {
            visit::visit_expr_path(self, expression);
        }
    }

    fn visit_pat_ident(&mut self, pattern: &PatIdent) {
        if !is_variable(pattern) {
            self.path(&[plain(&pattern.ident)]);
        }
        visit::visit_pat_ident(self, pattern);
    }

    fn visit_macro(&mut self, call: &Macro) {
        if let Some(name) = call.path.get_ident() {
            self.macro_by_name(&plain(name));
        }
        self.visit_path(&call.path);
        self.tokens(call.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &Attribute) {
        match &attribute.meta {
            Meta::List(list) => self.tokens(list.tokens.clone()),
            Meta::NameValue(pair) if !matches!(pair.value, Expr::Lit(_)) => self.visit_expr(&pair.value),
            _ => {}
        }
    }

    fn visit_impl_item(&mut self, item: &ImplItem) {
        let attributes = match item {
            ImplItem::Const(item) => &item.attrs,
            ImplItem::Fn(item) => &item.attrs,
            ImplItem::Type(item) => &item.attrs,
            ImplItem::Macro(item) => &item.attrs,
            _ => return,
        };
        if !is_test(attributes) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_trait_item(&mut self, item: &TraitItem) {
        let attributes = match item {
            TraitItem::Const(item) => &item.attrs,
            TraitItem::Fn(item) => &item.attrs,
            TraitItem::Type(item) => &item.attrs,
            TraitItem::Macro(item) => &item.attrs,
            _ => return,
        };
        if !is_test(attributes) {
            visit::visit_trait_item(self, item);
        }
    }

    fn visit_variant(&mut self, variant: &Variant) {
        if !is_test(&variant.attrs) {
            visit::visit_variant(self, variant);
        }
    }

    fn visit_field(&mut self, field: &Field) {
        if !is_test(&field.attrs) {
            visit::visit_field(self, field);
        }
    }

    fn visit_field_value(&mut self, field: &FieldValue) {
        if !is_test(&field.attrs) {
            visit::visit_field_value(self, field);
        }
    }

    fn visit_arm(&mut self, arm: &Arm) {
        if !is_test(&arm.attrs) {
            visit::visit_arm(self, arm);
        }
    }

    fn visit_local(&mut self, local: &Local) {
        if !is_test(&local.attrs) {
            visit::visit_local(self, local);
        }
    }

    fn visit_stmt_macro(&mut self, statement: &StmtMacro) {
        if !is_test(&statement.attrs) {
            visit::visit_stmt_macro(self, statement);
        }
    }
}
