//! Simulated annealing over the ways of gathering blocks, for the cheapest product.

use std::collections::HashMap;

use crate::blocks::{Block, Node};
use crate::plan::{Gathered, Role, Shape, build, ways};

/// The cost of a multiplication by a constant in the search: less than one, since some are shared in the end.
const CONSTANT: f64 = 0.7;

/// Steps of the search for each block. Twice as many change the counts by less than 1 %.
const STEPS_PER_BLOCK: usize = 2000;

/// The temperature, in operations, begins here and is halved from stage to stage.
const HOT: f64 = 4.0;
const STAGES: usize = 6;

/// Up to this many blocks the arithmetic is written out for every single change at the end; for more that takes
/// seconds and saves two operations in a thousand.
const REFINED: usize = 40;

/// For every block the chosen one of its [`ways`].
///
/// Simulated annealing on an estimate of the operations. The seed is fixed, and only operations occur that every
/// machine rounds alike: the outcome is the same everywhere.
pub(crate) fn choose(shape: Shape, blocks: &[Block]) -> Vec<Vec<Gathered>> {
    let ways: Vec<Vec<Vec<Gathered>>> = blocks.iter().map(|block| ways(block, shape)).collect();
    let mut chosen = anneal(shape, &ways);
    if blocks.len() <= REFINED {
        refine(shape, blocks, &ways, &mut chosen);
    }
    chosen.into_iter().zip(ways).map(|(chosen, mut ways)| ways.swap_remove(chosen)).collect()
}

fn anneal(shape: Shape, ways: &[Vec<Vec<Gathered>>]) -> Vec<usize> {
    let mut state = State::new(shape, ways);
    let mut random = Random(1);
    let (mut cost, mut best) = (0.0, (0.0, state.chosen.clone()));
    let mut temperature = HOT;
    for _ in 0..STAGES {
        for _ in 0..STEPS_PER_BLOCK * ways.len() / STAGES {
            // Propose another way for a random block.
            let block = random.below(ways.len());
            let (old, new) = (state.chosen[block], random.below(ways[block].len()));
            if old == new {
                continue;
            }
            let change = state.change(&ways[block], block, new);
            // Accept it by the criterion of Metropolis, and remember the best state.
            if change < temperature * random.exponential() {
                cost += change;
                if cost < best.0 {
                    best = (cost, state.chosen.clone());
                }
            } else {
                state.change(&ways[block], block, old);
            }
        }
        // Cool down.
        temperature *= 0.5;
    }
    best.1
}

/// Local search: changes single blocks as long as that makes the arithmetic shorter.
fn refine(shape: Shape, blocks: &[Block], ways: &[Vec<Vec<Gathered>>], chosen: &mut [usize]) {
    let cost = |chosen: &[usize]| {
        let gathered: Vec<&[Gathered]> = chosen.iter().zip(ways).map(|(&n, ways)| ways[n].as_slice()).collect();
        let (graph, results) = build(shape, blocks, &gathered);
        graph.cost(&results).total()
    };
    let mut best = cost(chosen);
    loop {
        let before = best;
        for block in 0..blocks.len() {
            for way in 0..ways[block].len() {
                let old = std::mem::replace(&mut chosen[block], way);
                let changed = cost(chosen);
                if changed <= best {
                    best = changed;
                } else {
                    chosen[block] = old;
                }
            }
        }
        if best == before {
            return;
        }
    }
}

/// Numbers of R at a pair, by role and kind.
type Counts = [[usize; 2]; 3];

struct State {
    shape: Shape,
    pairs: Vec<([Node; 2], Counts)>,
    number: HashMap<[Node; 2], usize>,
    chosen: Vec<usize>,
}

impl State {
    fn new(shape: Shape, ways: &[Vec<Vec<Gathered>>]) -> Self {
        let mut state = Self { shape, pairs: Vec::new(), number: HashMap::new(), chosen: vec![0; ways.len()] };
        for g in ways.iter().flatten().flatten() {
            let pair = [g.p, g.q];
            state.number.entry(pair).or_insert_with(|| {
                state.pairs.push((pair, Counts::default()));
                state.pairs.len() - 1
            });
        }
        for way in ways {
            state.count(&way[0], 1);
        }
        state
    }

    fn count(&mut self, way: &[Gathered], by: isize) {
        for g in way {
            let count = &mut self.pairs[self.number[&[g.p, g.q]]].1[g.role as usize][usize::from(!g.is_sum())];
            *count = count.strict_add_signed(by);
        }
    }

    /// Chooses another way for a block and returns by how much that changes the cost.
    fn change(&mut self, ways: &[Vec<Gathered>], block: usize, new: usize) -> f64 {
        let old = std::mem::replace(&mut self.chosen[block], new);
        let mut touched: Vec<usize> = ways[old].iter().chain(&ways[new]).map(|g| self.number[&[g.p, g.q]]).collect();
        touched.sort_unstable();
        touched.dedup();
        let cost = |state: &Self| touched.iter().map(|&n| state.cost(&state.pairs[n])).sum::<f64>();
        let before = cost(self);
        self.count(&ways[old], -1);
        self.count(&ways[new], 1);
        cost(self) - before
    }

    /// An estimate of the operations at one pair, as `plan` would write them.
    fn cost(&self, ([p, q], counts): &([Node; 2], Counts)) -> f64 {
        let mut cost = 0.0;
        for role in [Role::A, Role::B, Role::Out] {
            let [plus, minus] = counts[role as usize];
            if plus + minus == 0 {
                continue;
            }
            let widths = [if p.mu == 0 { 1 } else { 2 }, if p.mu == q.mu { 1 } else { 2 }];
            let terms = (plus * widths[0] + minus * widths[1]) as f64;
            let directions = [[*p, *q], [*q, *p]].into_iter().take(if p == q { 1 } else { 2 });
            let mut directions = directions.filter(|d| self.shape.uses(role, *d)).count();
            if role == Role::Out && self.shape.square {
                directions = 1;
            }
            let only_real = plus == 0 && p.mu == q.mu;
            let products = if only_real { p.width() } else { p.width() * q.width() };
            let joined = match (plus > 0, minus > 0) {
                (true, true) => 2 * widths[1],
                _ => 0,
            };
            cost += (CONSTANT + 1.0) * terms;
            if role == Role::Out {
                let complex =
                    if q.mu == 0 { 0 } else { usize::from(plus > 0) * 2 + usize::from(minus > 0) * widths[1] };
                cost += (products * (2 * directions - 1) + complex) as f64;
            } else {
                let first = usize::from(plus > 0) * widths[0] + usize::from(minus > 0) * widths[1];
                cost += (products * 2 * directions + joined) as f64 - first as f64;
            }
        }
        cost
    }
}

/// `SplitMix64` (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// Close to exponentially distributed, with mean 3/2.
    fn exponential(&mut self) -> f64 {
        f64::from(self.next().leading_zeros()) + (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}
