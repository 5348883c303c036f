//! Code generation: Rust or WGSL source from an expression graph.
//!
//! In Rust for lanes and for what is fused a sum with a product that nothing else needs becomes one operation, as the
//! registers have it.

use std::fmt::Write as _;

use super::graph::{Graph, Id, Op, Value};

/// Operations written on one line at most; more are named.
const LONGEST: usize = 5;

/// Operations of a function that the compiler may copy into its callers.
const INLINE: usize = 250;

/// A function to write.
pub(super) struct Function<'a> {
    /// One sentence.
    pub(super) doc: String,
    /// The part of the crate that sees it.
    pub(super) seen_by: &'static str,
    /// Everything between `fn` and the brace.
    pub(super) signature: String,
    pub(super) graph: &'a Graph,
    pub(super) results: &'a [Value],
}

impl Function<'_> {
    /// The source of the function.
    ///
    /// Every operation that something needs occurs once: as `*`, `+`, `-` or `.scale(`.
    pub(super) fn source(&self) -> String {
        let cost = self.graph.cost(self.results);
        let inline = if cost.total() <= INLINE { "#[inline]" } else { "#[inline(never)]" };
        let mut text = format!(
            "/// {}\n///\n/// {} multiplications and {} additions.\n{inline}\npub({}) fn {} {{\n",
            self.doc, cost.multiplications, cost.additions, self.seen_by, self.signature
        );
        self.body(&mut text, |constant| format!("k({constant:?})"));
        text + "}\n"
    }

    /// The function with its sums and products as methods that a machine may fuse, `x.times_plus(a, y)` for `a x + y`. Each
    /// product is that of a value by a number.
    pub(super) fn source_to_fuse(&self) -> String {
        let cost = self.graph.cost(self.results);
        let mut text = format!(
            "/// {}\n///\n/// {} multiplications and {} additions.\n#[inline(always)]\npub({}) fn {} {{\n",
            self.doc, cost.multiplications, cost.additions, self.seen_by, self.signature
        );
        self.write(&mut text, Dialect { constant: |c| format!("k({c:?})"), kind: Kind::Fused });
        text + "}\n"
    }

    /// The function for lanes, in `f32`: inputs are loaded where they are first needed.
    pub(super) fn source_for_lanes(&self) -> String {
        let mut text = format!("/// {}\n#[inline(always)]\npub({}) fn {} {{\n", self.doc, self.seen_by, self.signature);
        self.write(&mut text, Dialect { constant: |c| format!("k(simd, {:?})", c as f32), kind: Kind::Lanes });
        text + "}\n"
    }

    /// The statements, with constants as `constant` writes them.
    pub(super) fn body(&self, text: &mut String, constant: fn(f64) -> String) {
        self.write(text, Dialect { constant, kind: Kind::Operators });
    }

    fn write(&self, text: &mut String, dialect: Dialect) {
        let writer = Writer::new(self.graph, self.results, dialect);
        for id in 0..self.graph.len() {
            let results = self.results.iter().enumerate().filter(|(_, value)| value.is_some_and(|term| term.id == id));
            if let (Op::Input((array, place)), true) =
                (self.graph.op(id), dialect.is_for_lanes() && writer.uses[id] > 0)
            {
                let _ = writeln!(text, "    let {array}{place} = Wide::load(simd, &{array}[{place}], part);");
            }
            if writer.is_named(id) {
                let _ = writeln!(text, "    let t{id} = {};", writer.expression(id));
            }
            for (k, result) in results {
                let value = match (result.is_some_and(|term| term.negative), writer.is_named(id)) {
                    (false, true) => format!("t{id}"),
                    (false, false) => writer.expression(id),
                    (true, true) => format!("-t{id}"),
                    (true, false) => format!("-({})", writer.expression(id)),
                };
                let _ = if dialect.is_for_lanes() {
                    let value = if writer.is_named(id) { value } else { format!("({value})") };
                    writeln!(text, "    {value}.store(&mut out[{k}], part);")
                } else {
                    writeln!(text, "    out[{k}] = {value};")
                };
            }
        }
    }
}

/// What is written differently in the languages.
#[derive(Clone, Copy)]
struct Dialect {
    constant: fn(f64) -> String,
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Rust or WGSL with operators.
    Operators,
    /// Rust with methods.
    Fused,
    /// Rust for lanes.
    Lanes,
}

impl Dialect {
    fn is_for_lanes(self) -> bool {
        self.kind == Kind::Lanes
    }

    fn has_fused_sums(self) -> bool {
        self.kind != Kind::Operators
    }
}

struct Writer<'a> {
    graph: &'a Graph,
    uses: Vec<usize>,
    /// Operations in the expression of a value, itself and what is written inside it.
    length: Vec<usize>,
    named: Vec<bool>,
    dialect: Dialect,
}

impl<'a> Writer<'a> {
    fn new(graph: &'a Graph, results: &[Value], dialect: Dialect) -> Self {
        let uses = graph.uses(results);
        let mut writer = Self { graph, length: vec![0; uses.len()], named: vec![false; uses.len()], uses, dialect };
        for id in 0..graph.len() {
            let operation = usize::from(!matches!(graph.op(id), Op::Input(_)));
            writer.length[id] = operation;
            for operand in graph.op(id).operands() {
                // Name the longer operand first if the line grows too long, but no product that is fused with a sum.
                if dialect.has_fused_sums() && writer.is_sum(id) && writer.is_inner_product(operand) {
                    writer.length[id] += writer.length[operand];
                } else if writer.uses[operand] > 1 || writer.length[id] + writer.length[operand] > LONGEST {
                    writer.named[operand] = true;
                } else {
                    writer.length[id] += writer.length[operand];
                }
            }
        }
        writer
    }

    /// Whether the value has a line and a name of its own.
    fn is_named(&self, id: Id) -> bool {
        self.named[id] && self.uses[id] > 0 && !matches!(self.graph.op(id), Op::Input(_))
    }

    fn name(&self, id: Id) -> String {
        match self.graph.op(id) {
            Op::Input((array, place)) if self.dialect.is_for_lanes() => format!("{array}{place}"),
            Op::Input((array, place)) => format!("{array}[{place}]"),
            _ if self.is_named(id) => format!("t{id}"),
            _ => self.expression(id),
        }
    }

    /// As an operand of a product or on the right of a difference.
    fn factor(&self, id: Id) -> String {
        let is_open = self.is_sum(id) || self.dialect.is_for_lanes() && !matches!(self.graph.op(id), Op::Input(_));
        if is_open && !self.is_named(id) { format!("({})", self.expression(id)) } else { self.name(id) }
    }

    fn is_sum(&self, id: Id) -> bool {
        matches!(self.graph.op(id), Op::Add(..) | Op::Sub(..))
    }

    /// Whether the value is a product with one use.
    fn is_inner_product(&self, id: Id) -> bool {
        self.uses[id] == 1 && matches!(self.graph.op(id), Op::Scale(..) | Op::Mul(..))
    }

    /// The factors of a product, with the sign of a constant changed if `negative`; whether the sign is still to be changed.
    fn factors(&self, id: Id, negative: bool) -> (String, String, bool) {
        match self.graph.op(id) {
            Op::Scale(constant, x) => {
                let constant = f64::from_bits(constant);
                (self.factor(x), (self.dialect.constant)(if negative { -constant } else { constant }), false)
            }
            Op::Mul(x, y) if self.dialect.kind == Kind::Fused && self.is_scalar(x) => {
                (self.factor(y), self.name(x), negative)
            }
            Op::Mul(x, y) => (self.factor(x), self.name(y), negative),
            op => unreachable!("{op:?} is no product"),
        }
    }

    /// A sum or difference with a product in it, in one operation.
    fn fused(&self, id: Id) -> Option<String> {
        let (x, y, minus) = match self.graph.op(id) {
            Op::Add(x, y) => (x, y, false),
            Op::Sub(x, y) => (x, y, true),
            _ => return None,
        };
        let is_inner = |id| self.is_inner_product(id) && !self.is_named(id);
        if is_inner(y) {
            let (a, b, negate) = self.factors(y, minus);
            return Some(format!("{a}.{}({b}, {})", if negate { "times_from" } else { "times_plus" }, self.name(x)));
        }
        let (a, b, _) = if is_inner(x) { self.factors(x, false) } else { return None };
        Some(format!("{a}.{}({b}, {})", if minus { "times_minus" } else { "times_plus" }, self.name(y)))
    }

    fn expression(&self, id: Id) -> String {
        if let (true, Some(fused)) = (self.dialect.has_fused_sums(), self.fused(id)) {
            return fused;
        }
        match self.graph.op(id) {
            Op::Input(_) => self.name(id),
            Op::Scale(..) | Op::Mul(..) if self.dialect.kind == Kind::Fused => {
                let (a, b, _) = self.factors(id, false);
                format!("{a}.times({b})")
            }
            Op::Scale(constant, x) => {
                format!("{} * {}", self.factor(x), (self.dialect.constant)(f64::from_bits(constant)))
            }
            Op::Mul(x, y) if self.dialect.is_for_lanes() => format!("{} * {}", self.factor(x), self.factor(y)),
            Op::Mul(x, y) => match [self.is_scalar(x), self.is_scalar(y)] {
                [true, false] => format!("{}.scale({})", self.factor(y), self.name(x)),
                [false, true] => format!("{}.scale({})", self.factor(x), self.name(y)),
                _ => format!("{} * {}", self.factor(x), self.factor(y)),
            },
            Op::Add(x, y) => format!("{} + {}", self.name(x), self.factor(y)),
            Op::Sub(x, y) => format!("{} - {}", self.name(x), self.factor(y)),
        }
    }

    /// Whether the value is made of numbers alone, not colors: coefficients `z` of a zonal function, and the turns `p`, `q`
    /// and `r` of a rotation.
    fn is_scalar(&self, id: Id) -> bool {
        match self.graph.op(id) {
            Op::Input((array, _)) => "zpqr".contains(array),
            op => op.operands().all(|operand| self.is_scalar(operand)),
        }
    }
}
