//! Expression graphs with common subexpressions shared: every operation occurs once.

use std::collections::HashMap;

/// The place of an operation in its [`Graph`].
pub(crate) type Id = usize;

/// An input in the generated code: the name of an array and the place in it.
pub(crate) type Input = (char, usize);

/// One operation, or an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Op {
    Input(Input),
    /// A positive constant, by its bits, times a value.
    Scale(u64, Id),
    Mul(Id, Id),
    Add(Id, Id),
    Sub(Id, Id),
}

impl Op {
    pub(crate) fn operands(self) -> impl Iterator<Item = Id> {
        let (x, y) = match self {
            Self::Input(_) => (None, None),
            Self::Scale(_, x) => (Some(x), None),
            Self::Mul(x, y) | Self::Add(x, y) | Self::Sub(x, y) => (Some(x), Some(y)),
        };
        x.into_iter().chain(y)
    }
}

/// A value or its negative. The sign is kept outside the graph and costs nothing: it ends in an addition that
/// becomes a subtraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Term {
    pub(crate) negative: bool,
    pub(crate) id: Id,
}

/// A value that may be known to be zero.
pub(crate) type Value = Option<Term>;

/// The value with its sign changed if `negative`.
pub(crate) fn signed(value: Value, negative: bool) -> Value {
    value.map(|t| Term { negative: t.negative != negative, ..t })
}

/// Multiplications and additions; a subtraction is an addition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cost {
    pub(crate) multiplications: usize,
    pub(crate) additions: usize,
}

impl Cost {
    pub(crate) fn total(self) -> usize {
        self.multiplications + self.additions
    }
}

/// Operations in an order in which they can be carried out. An operation asked for twice is stored once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    ops: Vec<Op>,
    known: HashMap<Op, Id>,
}

impl Graph {
    pub(crate) fn op(&self, id: Id) -> Op {
        self.ops[id]
    }

    pub(crate) fn len(&self) -> usize {
        self.ops.len()
    }

    fn node(&mut self, op: Op) -> Id {
        *self.known.entry(op).or_insert_with(|| {
            self.ops.push(op);
            self.ops.len() - 1
        })
    }

    pub(crate) fn input(&mut self, input: Input) -> Value {
        Some(Term { negative: false, id: self.node(Op::Input(input)) })
    }

    /// `constant · x`.
    pub(crate) fn scale(&mut self, constant: f64, x: Value) -> Value {
        let x = signed(x, constant < 0.0)?;
        let id = if constant.abs() == 1.0 { x.id } else { self.node(Op::Scale(constant.abs().to_bits(), x.id)) };
        Some(Term { id, ..x })
    }

    pub(crate) fn mul(&mut self, x: Value, y: Value) -> Value {
        let (x, y) = (x?, y?);
        let id = self.node(Op::Mul(x.id.min(y.id), x.id.max(y.id)));
        Some(Term { negative: x.negative != y.negative, id })
    }

    pub(crate) fn add(&mut self, x: Value, y: Value) -> Value {
        let (Some(p), Some(q)) = (x, y) else {
            return x.or(y);
        };
        if p.negative == q.negative {
            let id = self.node(Op::Add(p.id.min(q.id), p.id.max(q.id)));
            return Some(Term { negative: p.negative, id });
        }
        let (plus, minus) = if q.negative { (p.id, q.id) } else { (q.id, p.id) };
        match self.known.get(&Op::Sub(minus, plus)) {
            Some(&id) => Some(Term { negative: true, id }),
            None => Some(Term { negative: false, id: self.node(Op::Sub(plus, minus)) }),
        }
    }

    pub(crate) fn sub(&mut self, x: Value, y: Value) -> Value {
        self.add(x, signed(y, true))
    }

    /// The number of uses of each operation by others that the results need; 0 marks dead code.
    pub(crate) fn uses(&self, results: &[Value]) -> Vec<usize> {
        let mut uses = vec![0; self.ops.len()];
        for result in results.iter().flatten() {
            uses[result.id] += 1;
        }
        for id in (0..self.ops.len()).rev() {
            if uses[id] > 0 {
                for operand in self.ops[id].operands() {
                    uses[operand] += 1;
                }
            }
        }
        uses
    }

    /// The cost of the results.
    pub(crate) fn cost(&self, results: &[Value]) -> Cost {
        let mut cost = Cost::default();
        for (op, uses) in self.ops.iter().zip(self.uses(results)) {
            match op {
                Op::Scale(..) | Op::Mul(..) if uses > 0 => cost.multiplications += 1,
                Op::Add(..) | Op::Sub(..) if uses > 0 => cost.additions += 1,
                _ => {}
            }
        }
        cost
    }
}
