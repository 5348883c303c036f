//! Code generation: Rust or WGSL source from an expression graph.

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
    /// Everything between `pub(super) fn` and the brace.
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
            "/// {}\n///\n/// {} multiplications and {} additions.\n{inline}\npub(super) fn {} {{\n",
            self.doc, cost.multiplications, cost.additions, self.signature
        );
        self.body(&mut text, |constant| format!("k({constant:?})"));
        text + "}\n"
    }

    /// The statements, with constants as `constant` writes them.
    pub(super) fn body(&self, text: &mut String, constant: fn(f64) -> String) {
        let writer = Writer::new(self.graph, self.results, constant);
        for id in 0..self.graph.len() {
            let results = self.results.iter().enumerate().filter(|(_, value)| value.is_some_and(|term| term.id == id));
            if writer.is_named(id) {
                let _ = writeln!(text, "    let t{id} = {};", writer.expression(id));
            }
            for (k, _) in results {
                let value = if writer.is_named(id) { format!("t{id}") } else { writer.expression(id) };
                let _ = writeln!(text, "    out[{k}] = {value};");
            }
        }
    }
}

struct Writer<'a> {
    graph: &'a Graph,
    uses: Vec<usize>,
    /// Operations in the expression of a value, itself and what is written inside it.
    length: Vec<usize>,
    named: Vec<bool>,
    constant: fn(f64) -> String,
}

impl<'a> Writer<'a> {
    fn new(graph: &'a Graph, results: &[Value], constant: fn(f64) -> String) -> Self {
        let uses = graph.uses(results);
        let mut writer = Self { graph, length: vec![0; uses.len()], named: vec![false; uses.len()], uses, constant };
        for id in 0..graph.len() {
            let operation = usize::from(!matches!(graph.op(id), Op::Input(_)));
            writer.length[id] = operation;
            for operand in graph.op(id).operands() {
                // Name the longer operand first if the line grows too long.
                if writer.uses[operand] > 1 || writer.length[id] + writer.length[operand] > LONGEST {
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
            Op::Input((array, place)) => format!("{array}[{place}]"),
            _ if self.is_named(id) => format!("t{id}"),
            _ => self.expression(id),
        }
    }

    /// As an operand of a product or on the right of a difference.
    fn factor(&self, id: Id) -> String {
        let is_sum = matches!(self.graph.op(id), Op::Add(..) | Op::Sub(..));
        if is_sum && !self.is_named(id) { format!("({})", self.expression(id)) } else { self.name(id) }
    }

    fn expression(&self, id: Id) -> String {
        match self.graph.op(id) {
            Op::Input(_) => self.name(id),
            Op::Scale(constant, x) => {
                format!("{} * {}", self.factor(x), (self.constant)(f64::from_bits(constant)))
            }
            Op::Mul(x, y) => match [self.is_scalar(x), self.is_scalar(y)] {
                [true, false] => format!("{}.scale({})", self.factor(y), self.name(x)),
                [false, true] => format!("{}.scale({})", self.factor(x), self.name(y)),
                _ => format!("{} * {}", self.factor(x), self.factor(y)),
            },
            Op::Add(x, y) => format!("{} + {}", self.name(x), self.factor(y)),
            Op::Sub(x, y) => format!("{} - {}", self.name(x), self.factor(y)),
        }
    }

    /// Whether the value is made of coefficients `z` of a zonal function alone, which are numbers, not colors.
    fn is_scalar(&self, id: Id) -> bool {
        match self.graph.op(id) {
            Op::Input((array, _)) => array == 'z',
            op => op.operands().all(|operand| self.is_scalar(operand)),
        }
    }
}
