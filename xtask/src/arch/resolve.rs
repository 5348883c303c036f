//! Name resolution: from a path to the file that defines its item, through `use` and re-exports.

use super::modules::Tree;

/// A meaning of a name. One name can have several: a module and a function of it, re-exported, share theirs.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    Module(usize),
    /// An item, with the module that defines it.
    Item(usize, String),
}

/// The imports being followed, module and number, so that those that lead back to themselves end.
type Followed = Vec<(usize, usize)>;

impl Tree {
    /// The meanings of the path in this module; nothing where it leads out of the crate. The path stops at the first
    /// item: what follows are variants and associated functions.
    pub(super) fn resolve(&self, module: usize, path: &[String]) -> Vec<Meaning> {
        self.follow(module, path, &mut Followed::new())
    }

    fn follow(&self, module: usize, path: &[String], followed: &mut Followed) -> Vec<Meaning> {
        let Some((first, rest)) = path.split_first() else { return Vec::new() };
        let mut meanings = match first.as_str() {
            "crate" => self.ancestors(module).last().map(Meaning::Module).into_iter().collect(),
            "self" | "super" => self.step(module, first, followed),
            name => self.look_up(module, name, followed),
        };
        for name in rest {
            let modules = modules_of(&meanings);
            if modules.is_empty() {
                break;
            }
            meanings = modules.into_iter().flat_map(|module| self.step(module, name, followed)).collect();
        }
        meanings
    }

    /// The meanings of the name right behind a module's path.
    fn step(&self, module: usize, name: &str, followed: &mut Followed) -> Vec<Meaning> {
        match name {
            "self" => return vec![Meaning::Module(module)],
            "super" => return self.modules[module].parent.map(Meaning::Module).into_iter().collect(),
            _ => {}
        }
        let found = self.look_up(module, name, followed);
        if found.is_empty() && self.modules[module].makes_items {
            return vec![Meaning::Item(module, name.into())];
        }
        found
    }

    /// The meanings of the name within the module: items and imports of this name, else those that its globs bring.
    fn look_up(&self, module: usize, name: &str, followed: &mut Followed) -> Vec<Meaning> {
        let here = &self.modules[module];
        // Take the child module and the item of this name.
        let mut found: Vec<Meaning> = here.modules.get(name).map(|&child| Meaning::Module(child)).into_iter().collect();
        if here.items.contains(name) {
            found.push(Meaning::Item(module, name.into()));
        }
        // Follow the imports of this name.
        self.add_imports(module, name, name, followed, &mut found);
        // Follow the globs where no item was found.
        if !found.iter().any(|meaning| matches!(meaning, Meaning::Item(..))) {
            self.add_imports(module, "*", name, followed, &mut found);
        }
        found
    }

    /// Adds the meanings of the name through the imports named `called`, which is `*` for globs.
    fn add_imports(&self, module: usize, called: &str, name: &str, followed: &mut Followed, found: &mut Vec<Meaning>) {
        for (number, import) in self.modules[module].imports.iter().enumerate() {
            if import.name != called || followed.contains(&(module, number)) {
                continue;
            }
            followed.push((module, number));
            let mut meanings = self.follow(module, &import.path, followed);
            if called == "*" {
                // Take only what stands there by name: a glob of an enum's variants brings no items.
                meanings = modules_of(&meanings).into_iter().flat_map(|m| self.look_up(m, name, followed)).collect();
            }
            followed.pop();
            meanings.retain(|meaning| !found.contains(meaning));
            found.extend(meanings);
        }
    }
}

/// The modules among the meanings.
fn modules_of(meanings: &[Meaning]) -> Vec<usize> {
    let module = |meaning: &Meaning| if let Meaning::Module(module) = meaning { Some(*module) } else { None };
    meanings.iter().filter_map(module).collect()
}
