//! Factoring of SH products: blocks of Gaunt coefficients gathered into pairs, and the arithmetic of the pairs.

use std::collections::BTreeMap;

use lobe_sh::basis::coefficient_index;

use crate::blocks::{Block, Node};
use crate::cover::{Edge, multiply_at_source};
use crate::graph::{Graph, Term, Value, signed};

// A pair of nodes (P, Q), P.μ >= Q.μ, is completed to blocks by nodes R of two kinds, R.μ = P.μ + Q.μ and
// R.μ = P.μ - Q.μ, and the blocks gathered at the pair are
//
//   Re(P Q S̄⁺) + Re(Q S⁻ P̄)        S± = Σ_R D R
//
// Of the two factors a, b and the product c one takes the place of R:
//
//   R is a:   c_P += Q̄_b S⁺_a + Q_b S⁻_a        c_Q += P̄_b S⁺_a + P_b S̄⁻_a
//   R is b:   the same with a and b exchanged
//   R is c:   c_R += D t⁺ or D t⁻               t⁺ = P_a Q_b + P_b Q_a        t⁻ = P_a Q̄_b + P_b Q̄_a
//
// For P = Q, one of the two lines and one of the two terms. In real numbers, with S± = (s±, r±) and four sums
//
//   u1 = s⁺ + s⁻   u2 = r⁺ - r⁻   u3 = r⁺ + r⁻   u4 = s⁻ - s⁺
//   c_P += (Qc u1 + Qs u2, Qc u3 + Qs u4)        c_Q += (Pc u1 + Ps u3, Pc u2 + Ps u4)
//
// Every block has to be gathered so that each distribution of a, b and c over its nodes occurs once: all three
// roles at one of its pairs, or one role at all of its pairs. The first is the factoring of Snyder (2006), in complex
// numbers; the second makes the product matrix of one factor, which is better when the orders differ.

/// The role of R in a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    A = 0,
    B = 1,
    Out = 2,
}

/// One block, or a part of its distributions, at the pair `(p, q)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gathered {
    pub(crate) p: Node,
    pub(crate) q: Node,
    pub(crate) r: Node,
    pub(crate) role: Role,
    /// All three roles of the block are gathered at this pair.
    pub(crate) all_roles: bool,
}

impl Gathered {
    fn new([x, y]: [Node; 2], r: Node, role: Role, all_roles: bool) -> Self {
        Self { p: x.max(y), q: x.min(y), r, role, all_roles }
    }

    /// Whether `r.μ` is the sum of the other two, not their difference.
    pub(crate) fn is_sum(&self) -> bool {
        self.r.mu == self.p.mu + self.q.mu
    }
}

/// A product to make code for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Of the two factors and the product.
    pub(crate) orders: [usize; 3],
    /// Both factors are the same, and called `a`.
    pub(crate) square: bool,
}

impl Shape {
    /// Whether the factor or product of `role` has coefficients for the node.
    pub(crate) fn has(&self, role: Role, node: Node) -> bool {
        node.l < self.orders[role as usize]
    }

    /// Whether anything comes of `gathered` with the given distribution over P and Q of the two roles that R leaves.
    pub(crate) fn uses(&self, role: Role, [p, q]: [Node; 2]) -> bool {
        match role {
            Role::A => self.has(Role::B, q) && self.has(Role::Out, p),
            Role::B => self.has(Role::A, q) && self.has(Role::Out, p),
            Role::Out => self.has(Role::A, p) && self.has(Role::B, q),
        }
    }

    /// Whether there is an R for this role, and a use of it.
    pub(crate) fn keeps(&self, g: &Gathered) -> bool {
        self.has(g.role, g.r) && (self.uses(g.role, [g.p, g.q]) || self.uses(g.role, [g.q, g.p]))
    }
}

/// Every way of gathering a block.
pub(crate) fn ways(block: &Block, shape: Shape) -> Vec<Vec<Gathered>> {
    let [x, y, z] = block.nodes;
    let roles: &[Role] = if shape.square { &[Role::A, Role::Out] } else { &[Role::A, Role::B, Role::Out] };
    // Pairs with what completes them; the equal nodes of a block are neighbors.
    let (completed, at_one_pair) = match (x == y, y == z) {
        (true, true) => return vec![vec![Gathered::new([x, x], x, Role::Out, false)]],
        (true, false) => (vec![([x, x], z), ([x, z], x)], vec![0]),
        (false, true) => (vec![([z, z], x), ([x, z], z)], vec![0]),
        (false, false) => (vec![([x, y], z), ([x, z], y), ([y, z], x)], vec![0, 1, 2]),
    };
    let gather = |n: usize, role, all_roles| Gathered::new(completed[n].0, completed[n].1, role, all_roles);
    let one_pair = at_one_pair.iter().map(|&n| roles.iter().map(|&role| gather(n, role, true)).collect());
    let one_role = roles.iter().map(|&role| (0..completed.len()).map(|n| gather(n, role, false)).collect());
    one_pair.chain(one_role).map(|way: Vec<Gathered>| way.into_iter().filter(|g| shape.keeps(g)).collect()).collect()
}

/// A complex value; real values have no imaginary part.
#[derive(Clone, Copy, Debug, Default)]
struct Complex {
    re: Value,
    im: Value,
}

impl Complex {
    fn parts(self) -> [Value; 2] {
        [self.re, self.im]
    }
}

/// The terms gathered at one pair, by role and kind of R, the sums first.
type PairSums = [[Vec<(Node, f64)>; 2]; 3];

/// Arithmetic under construction.
struct Builder {
    shape: Shape,
    graph: Graph,
    /// The product's coefficients as far as they are known.
    out: Vec<Value>,
    /// Sums still to be multiplied by a constant and added to a node of the product.
    pending: BTreeMap<(Node, u64), Complex>,
}

/// The coefficients of the product, each block gathered in the given way.
pub(crate) fn build(shape: Shape, blocks: &[Block], chosen: &[&[Gathered]]) -> (Graph, Vec<Value>) {
    // Gather the terms of every pair.
    let mut pairs: BTreeMap<[Node; 2], PairSums> = BTreeMap::new();
    for (block, way) in blocks.iter().zip(chosen) {
        for g in *way {
            // Double the constant of a square, whose two factors are one and are gathered once.
            let twice = shape.square && if g.role == Role::Out { g.p != g.q } else { g.all_roles };
            let constant = if twice { 2.0 * block.constant } else { block.constant };
            let sums = pairs.entry([g.p, g.q]).or_default();
            sums[g.role as usize][usize::from(!g.is_sum())].push((g.r, constant));
        }
    }
    let order_out = shape.orders[2];
    let mut builder =
        Builder { shape, graph: Graph::default(), out: vec![None; order_out * order_out], pending: BTreeMap::new() };
    // Place the constants, at sources or at sums.
    let at_source = [Role::A, Role::B, Role::Out].map(|role| builder.constants_at_source(&pairs, role));
    // Write the arithmetic of each pair.
    for (n, (pair, sums)) in pairs.iter().enumerate() {
        for role in [Role::A, Role::B] {
            builder.factor_completes(*pair, n, role, &sums[role as usize], &at_source[role as usize]);
        }
        builder.product_completes(*pair, n, &sums[Role::Out as usize], &at_source[Role::Out as usize]);
    }
    // Multiply the sums whose constants come last.
    builder.flush();
    (builder.graph, builder.out)
}

/// The places (pair, kind, node) whose constant multiplies the factor, or the `t±`, before anything is summed.
type AtSource = BTreeMap<(usize, usize, Node), bool>;

impl Builder {
    fn constants_at_source(&self, pairs: &BTreeMap<[Node; 2], PairSums>, role: Role) -> AtSource {
        let number = |node: Node| coefficient_index(node.l, node.mu as isize);
        let (mut edges, mut places) = (Vec::new(), Vec::new());
        for (n, sums) in pairs.values().enumerate() {
            for (kind, terms) in sums[role as usize].iter().enumerate() {
                for &(r, constant) in terms {
                    let (node, sum) = (number(r), 2 * n + kind);
                    let (source, sink) = if role == Role::Out { (sum, node) } else { (node, sum) };
                    edges.push(Edge { source, sink, constant });
                    places.push((n, kind, r));
                }
            }
        }
        places.into_iter().zip(multiply_at_source(&edges)).collect()
    }

    /// The coefficients of a factor at a node, zero past its order.
    fn factor(&mut self, role: Role, node: Node) -> Complex {
        if !self.shape.has(role, node) {
            return Complex::default();
        }
        let name = if role == Role::B && !self.shape.square { 'b' } else { 'a' };
        let m = node.mu as isize;
        let re = self.graph.input((name, coefficient_index(node.l, m)));
        let im = if m > 0 { self.graph.input((name, coefficient_index(node.l, -m))) } else { None };
        Complex { re, im }
    }

    fn add_to_out(&mut self, node: Node, value: Complex) {
        if !self.shape.has(Role::Out, node) {
            return;
        }
        let m = node.mu as isize;
        for (m, part) in [m, -m].into_iter().zip(value.parts()).take(node.width()) {
            let place = &mut self.out[coefficient_index(node.l, m)];
            *place = self.graph.add(*place, part);
        }
    }

    fn add(&mut self, x: Complex, y: Complex) -> Complex {
        Complex { re: self.graph.add(x.re, y.re), im: self.graph.add(x.im, y.im) }
    }

    fn scale(&mut self, constant: f64, x: Complex) -> Complex {
        Complex { re: self.graph.scale(constant, x.re), im: self.graph.scale(constant, x.im) }
    }

    /// `x y + z w`.
    fn dot(&mut self, x: Value, y: Value, z: Value, w: Value) -> Value {
        let (xy, zw) = (self.graph.mul(x, y), self.graph.mul(z, w));
        self.graph.add(xy, zw)
    }

    /// `S = Σ D R`.
    fn sum(&mut self, place: (usize, usize), role: Role, terms: &[(Node, f64)], at_source: &AtSource) -> Complex {
        let mut sum = Complex::default();
        let mut of_constant: BTreeMap<u64, Complex> = BTreeMap::new();
        for &(r, constant) in terms {
            let factor = self.factor(role, r);
            if at_source[&(place.0, place.1, r)] {
                let product = self.scale(constant, factor);
                sum = self.add(sum, product);
            } else {
                let gathered = of_constant.entry(constant.abs().to_bits()).or_default();
                let signed = factor.parts().map(|part| signed(part, constant < 0.0));
                gathered.re = self.graph.add(gathered.re, signed[0]);
                gathered.im = self.graph.add(gathered.im, signed[1]);
            }
        }
        for (constant, gathered) in of_constant {
            let product = self.scale(f64::from_bits(constant), gathered);
            sum = self.add(sum, product);
        }
        sum
    }

    /// R is a factor: `c_P` and `c_Q` by the four sums.
    fn factor_completes(
        &mut self,
        [p, q]: [Node; 2],
        n: usize,
        role: Role,
        sums: &[Vec<(Node, f64)>; 2],
        at: &AtSource,
    ) {
        // Form the four sums of S⁺ and S⁻.
        let plus = self.sum((n, 0), role, &sums[0], at);
        let minus = self.sum((n, 1), role, &sums[1], at);
        let u1 = self.graph.add(plus.re, minus.re);
        let u2 = self.graph.sub(plus.im, minus.im);
        let u3 = self.graph.add(plus.im, minus.im);
        let u4 = self.graph.sub(minus.re, plus.re);
        let other = if role == Role::A { Role::B } else { Role::A };
        // Multiply them by the other factor at each node.
        let mut towards = |into: Node, from: Node, [x, y]: [Value; 2]| {
            if self.shape.uses(role, [into, from]) {
                let f = self.factor(other, from);
                let re = self.dot(f.re, u1, f.im, x);
                let im = self.dot(f.re, y, f.im, u4);
                self.add_to_out(into, Complex { re, im });
            }
        };
        towards(p, q, [u2, u3]);
        if p != q {
            towards(q, p, [u3, u2]);
        }
    }

    /// R is the product: `c_R` by the products `t±` of the factors.
    fn product_completes(&mut self, [p, q]: [Node; 2], n: usize, sums: &[Vec<(Node, f64)>; 2], at: &AtSource) {
        if sums.iter().all(Vec::is_empty) {
            return;
        }
        // Form the products cc, ss, cs and sc of P and Q.
        let mut products = [None; 4];
        for [x, y] in if p == q || self.shape.square { vec![[p, q]] } else { vec![[p, q], [q, p]] } {
            let (mut f, mut g) = (self.factor(Role::A, x), self.factor(Role::B, y));
            if x != p {
                (f, g) = (g, f);
            }
            let all = [(f.re, g.re), (f.im, g.im), (f.re, g.im), (f.im, g.re)];
            for (sum, (f, g)) in products.iter_mut().zip(all) {
                let product = self.graph.mul(f, g);
                *sum = self.graph.add(*sum, product);
            }
        }
        let [cc, ss, cs, sc] = products;
        // Combine them to t⁺ and t⁻.
        let plus = Complex { re: self.graph.sub(cc, ss), im: self.graph.add(cs, sc) };
        let minus = Complex { re: self.graph.add(cc, ss), im: self.graph.sub(sc, cs) };
        // Add them to the product, or keep them for their constants.
        for (kind, t) in [plus, minus].into_iter().enumerate() {
            for &(r, constant) in &sums[kind] {
                if at[&(n, kind, r)] {
                    let product = self.scale(constant, t);
                    self.add_to_out(r, product);
                } else {
                    let parts = t.parts().map(|part| signed(part, constant < 0.0));
                    let signed = Complex { re: parts[0], im: parts[1] };
                    let before = self.pending.get(&(r, constant.abs().to_bits())).copied().unwrap_or_default();
                    let sum = self.add(before, signed);
                    self.pending.insert((r, constant.abs().to_bits()), sum);
                }
            }
        }
    }

    /// Multiplies by the constants that were left for last.
    fn flush(&mut self) {
        for ((node, constant), sum) in std::mem::take(&mut self.pending) {
            let product = self.scale(f64::from_bits(constant), sum);
            self.add_to_out(node, product);
        }
    }
}

/// Whether a coefficient would need a sign of its own.
pub(crate) fn is_negative(value: Value) -> bool {
    value.is_some_and(|Term { negative, .. }| negative)
}
