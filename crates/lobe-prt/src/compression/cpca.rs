//! Clustered principal component analysis (CPCA).

use lobe_io::parallel;

use crate::compression::eigen::dot;
use crate::compression::nearest::Nearest;
use crate::compression::pca::{Rows, Subspace};
use crate::job::meter::Meter;

/// Iterations after every doubling of the clusters, but the last.
const SETTLING: usize = 3;

/// Iterations on the two halves of a cluster that is split.
const HALVING: usize = 4;

/// Split-and-merge moves: clusters of least use dissolved while those of largest error are split, one after the other.
const MOVES: usize = 8;

/// Rows whose errors are summed by one thread.
const CHUNK: usize = 512;

/// An assignment of rows to subspaces.
#[derive(Clone, Debug)]
pub(crate) struct Clustering {
    /// The subspace of every row.
    pub(crate) of_row: Vec<u32>,
    pub(crate) spaces: Vec<Subspace>,
    /// The squared distance of every row from its subspace.
    errors: Vec<f64>,
    /// The sum of the errors at the start and after every iteration since the last doubling; after a cluster was moved,
    /// from there on again.
    pub(crate) history: Vec<f64>,
}

impl Clustering {
    /// The sum of the squared distances, in the order of the rows.
    pub(crate) fn error(&self) -> f64 {
        self.errors.iter().sum()
    }

    fn members(&self) -> Vec<Vec<u32>> {
        let mut members = vec![Vec::new(); self.spaces.len()];
        for (r, k) in self.of_row.iter().enumerate() {
            members[*k as usize].push(r as u32);
        }
        members
    }

    /// The better of two; the first of equals.
    pub(crate) fn better(self, other: Self) -> Self {
        if other.error() < self.error() { other } else { self }
    }
}

/// Clustered principal components after [Sloan 2003]: rows go to the subspace that is nearest, subspaces are fitted to
/// their rows, in turn, so that the sum of squared distances falls until neither changes anything (Lloyd's iteration).
///
/// Clusters begin as one, the ordinary principal components, and are doubled by splitting those of largest error
/// (Linde, Buzo and Gray 1980). A half's own subspace is no farther from its rows than the whole's was: so the error
/// never rises, whatever the number of clusters, and stays below that of principal components alone.
pub(crate) struct Cpca<'a> {
    rows: Rows<'a>,
    nearest: Nearest,
    iterations: usize,
    tolerance: f64,
}

impl<'a> Cpca<'a> {
    pub(crate) fn new(rows: Rows<'a>, iterations: usize, tolerance: f64) -> Self {
        let all: Vec<u32> = (0..rows.count() as u32).collect();
        let center = Subspace::fit(rows, &all, 0).mean;
        Self { rows, nearest: Nearest::new(rows, center), iterations, tolerance }
    }

    /// All rows in one cluster: principal components.
    pub(crate) fn one(&self, components: usize) -> Clustering {
        self.fitted(vec![0; self.rows.count()], 1, components)
    }

    /// The steps of [`Cpca::grown`] at most, in which an iteration is about as long as its work: covariances of all
    /// rows, then their distances from all subspaces.
    pub(crate) fn steps_to_grow(&self, from: usize, clusters: usize, components: usize) -> usize {
        let (mut steps, mut now) = (0, from);
        while now < clusters {
            now = clusters.min(2 * now);
            let iterations = if now == clusters { self.iterations } else { SETTLING };
            steps += iterations * self.steps_of_iteration(now, components);
        }
        let moves = if clusters > 1 { MOVES } else { 0 };
        steps + moves * (SETTLING + self.iterations) * self.steps_of_iteration(clusters, components)
    }

    /// The steps of [`Cpca::with_components`] at most.
    pub(crate) fn steps_to_settle(&self, clusters: usize, components: usize) -> usize {
        self.iterations * self.steps_of_iteration(clusters, components)
    }

    fn steps_of_iteration(&self, clusters: usize, components: usize) -> usize {
        self.rows.width() + clusters * (components + 1)
    }

    /// At most `clusters` clusters, by doubling those of `start`. There are fewer if fewer leave nothing.
    pub(crate) fn grown(
        &self,
        start: Clustering,
        clusters: usize,
        components: usize,
        meter: &mut Meter<'_>,
    ) -> Clustering {
        let end = meter.done() + self.steps_to_grow(start.spaces.len(), clusters, components);
        let mut now = start;
        // Double the clusters, and let each set of them settle.
        while now.spaces.len() < clusters && !meter.is_stopped() {
            let before = now.spaces.len();
            let target = clusters.min(2 * before);
            now = self.split(now, target, components);
            if now.spaces.len() == before {
                break;
            }
            let last = now.spaces.len() >= clusters;
            now = self.settled(now, components, if last { self.iterations } else { SETTLING }, meter);
        }
        // Split and merge: move clusters of little use to where the error is largest.
        now = self.moved(now, components, meter);
        meter.reach(end);
        now
    }

    /// Split and merge: splits the cluster of largest error and dissolves the one that others replace best, as long as
    /// that lowers the error: Lloyd's iteration cannot move a cluster past others.
    fn moved(&self, mut now: Clustering, components: usize, meter: &mut Meter<'_>) -> Clustering {
        let clusters = now.spaces.len();
        for _ in 0..if clusters > 1 { MOVES } else { 0 } {
            if meter.is_stopped() {
                break;
            }
            // Split the cluster of largest error.
            let more = self.split(now.clone(), clusters + 1, components);
            // Dissolve the one whose rows lose least by going elsewhere.
            let fewer = self.dissolved(self.settled(more, components, SETTLING, meter), clusters, components);
            // Keep the result if it is better.
            let mut other = self.settled(fewer, components, self.iterations, meter);
            if other.error() >= (1.0 - self.tolerance) * now.error() {
                break;
            }
            other.history.splice(0..0, now.history);
            now = other;
        }
        now
    }

    /// Gives the rows of the clusters whose loss is least to the next nearest ones, until `clusters` are left.
    fn dissolved(&self, mut now: Clustering, clusters: usize, components: usize) -> Clustering {
        while now.spaces.len() > clusters {
            // Find the second nearest subspace of every row.
            let next = self.nearest.find(&now.spaces, Some(&now.of_row));
            let mut scratch = Vec::new();
            // Sum the error that each cluster would add if its rows went there.
            let mut losses = vec![0.0; now.spaces.len()];
            for (r, k) in next.iter().enumerate() {
                let other = now.spaces[*k as usize].error(self.rows.row(r as u32), &mut scratch);
                losses[now.of_row[r] as usize] += other - now.errors[r];
            }
            // Dissolve the cluster that adds least, and refit the others.
            let least = losses.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(k, _)| k as u32);
            for (k, next) in now.of_row.iter_mut().zip(next) {
                *k = if *k == least { next } else { *k };
            }
            self.without_empty(&mut now);
            self.refit(&mut now, components);
        }
        now
    }

    /// The same clusters with another number of components, settled.
    pub(crate) fn with_components(&self, start: &Clustering, components: usize, meter: &mut Meter<'_>) -> Clustering {
        let refitted = self.fitted(start.of_row.clone(), start.spaces.len(), components);
        self.settled(refitted, components, self.iterations, meter)
    }

    fn fitted(&self, of_row: Vec<u32>, clusters: usize, components: usize) -> Clustering {
        let nothing = Subspace { mean: Vec::new(), bases: Vec::new() };
        let mut fitted =
            Clustering { of_row, spaces: vec![nothing; clusters], errors: Vec::new(), history: Vec::new() };
        self.refit(&mut fitted, components);
        fitted.history.push(fitted.error());
        fitted
    }

    fn refit(&self, clustering: &mut Clustering, components: usize) {
        let members = clustering.members();
        clustering.spaces = parallel::map(members.len(), &|k| Subspace::fit(self.rows, &members[k], components));
        self.measure(clustering);
    }

    fn measure(&self, clustering: &mut Clustering) {
        let Clustering { of_row, spaces, errors, .. } = clustering;
        errors.resize(of_row.len(), 0.0);
        parallel::rows(errors, CHUNK, &|chunk, errors| {
            let mut scratch = Vec::new();
            for (k, error) in errors.iter_mut().enumerate() {
                let r = chunk * CHUNK + k;
                *error = spaces[of_row[r] as usize].error(self.rows.row(r as u32), &mut scratch);
            }
        });
    }

    /// Lloyd's iteration, until the error falls by less than the tolerance.
    fn settled(&self, mut now: Clustering, components: usize, iterations: usize, meter: &mut Meter<'_>) -> Clustering {
        let one = self.steps_of_iteration(now.spaces.len(), components);
        let end = meter.done() + iterations * one;
        let mut error = now.error();
        now.history = vec![error];
        for _ in 0..iterations {
            if meter.is_stopped() {
                break;
            }
            // Give each row to its nearest subspace; end if none moves.
            let moved = self.assign(&mut now);
            if moved == 0 {
                break;
            }
            // Fit each subspace to its rows.
            self.refit(&mut now, components);
            meter.step(one);
            // End where the error hardly falls any more.
            let before = std::mem::replace(&mut error, now.error());
            now.history.push(error);
            if before - error <= self.tolerance * before {
                break;
            }
        }
        self.without_empty(&mut now);
        meter.reach(end);
        now
    }

    /// Moves rows to nearer subspaces; returns how many. A row moves only if it gets nearer in full precision.
    fn assign(&self, clustering: &mut Clustering) -> usize {
        // Find candidates in single precision.
        let candidates = self.nearest.find(&clustering.spaces, None);
        // Find how near these are in full precision.
        let Clustering { of_row, spaces, errors, .. } = &mut *clustering;
        let mut found = errors.clone();
        parallel::rows(&mut found, CHUNK, &|chunk, found| {
            let mut scratch = Vec::new();
            for (found, r) in found.iter_mut().zip(chunk * CHUNK..) {
                if candidates[r] != of_row[r] {
                    *found = spaces[candidates[r] as usize].error(self.rows.row(r as u32), &mut scratch);
                }
            }
        });
        // Move those that get nearer.
        let mut moved = 0;
        for (r, found) in found.into_iter().enumerate() {
            if found < errors[r] {
                (of_row[r], errors[r]) = (candidates[r], found);
                moved += 1;
            }
        }
        moved + self.reseed(clustering)
    }

    /// Gives every empty cluster the worst row there is.
    fn reseed(&self, clustering: &mut Clustering) -> usize {
        let mut counts = vec![0_usize; clustering.spaces.len()];
        clustering.of_row.iter().for_each(|k| counts[*k as usize] += 1);
        let mut reseeded = 0;
        for empty in (0..counts.len()).filter(|k| counts[*k] == 0) {
            let worst = clustering.errors.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
            let Some((r, error)) = worst.map(|(r, e)| (r, *e)) else { break };
            if error <= 0.0 {
                break;
            }
            clustering.of_row[r] = empty as u32;
            clustering.errors[r] = 0.0;
            reseeded += 1;
        }
        reseeded
    }

    fn without_empty(&self, clustering: &mut Clustering) {
        let mut used = vec![false; clustering.spaces.len()];
        clustering.of_row.iter().for_each(|k| used[*k as usize] = true);
        let mut next = 0;
        let new_index: Vec<u32> = used.iter().map(|used| (next, next += u32::from(*used)).0).collect();
        clustering.of_row.iter_mut().for_each(|k| *k = new_index[*k as usize]);
        let mut used = used.into_iter();
        clustering.spaces.retain(|_| used.next().unwrap_or(false));
    }

    /// Splits the clusters of largest error until there are `target`, or none is left that can be split.
    fn split(&self, mut now: Clustering, target: usize, components: usize) -> Clustering {
        let members = now.members();
        // Choose the clusters of largest error.
        let mut worst: Vec<(usize, f64)> = members
            .iter()
            .enumerate()
            .map(|(k, members)| (k, members.iter().map(|r| now.errors[*r as usize]).sum()))
            .filter(|(_, error)| *error > 0.0)
            .collect();
        worst.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        worst.truncate(target - now.spaces.len());
        // Halve each of them.
        let halves: Vec<Option<Vec<bool>>> = parallel::map(worst.len(), &|i| {
            let (k, error) = worst[i];
            self.halved(&members[k], error, components)
        });
        // Give each second half a cluster of its own.
        for ((k, _), second) in worst.into_iter().zip(halves) {
            let Some(second) = second else { continue };
            let fresh = now.spaces.len() as u32;
            now.spaces.push(now.spaces[k].clone());
            for (r, second) in members[k].iter().zip(second) {
                if second {
                    now.of_row[*r as usize] = fresh;
                }
            }
        }
        // Fit all subspaces anew.
        self.refit(&mut now, components);
        now.history = vec![now.error()];
        now
    }

    /// The members of the second half. Tried are the cuts through the mean across the direction of largest variance,
    /// which unbends a curved cluster, and across the largest that the components leave, which parts two flat ones.
    fn halved(&self, members: &[u32], error: f64, components: usize) -> Option<Vec<bool>> {
        // Fit the principal components of the whole cluster.
        let whole = Subspace::fit(self.rows, members, components + 1);
        let width = self.rows.width();
        let mut best: Option<(f64, Vec<bool>)> = None;
        let mut axes = vec![0, whole.rank().saturating_sub(1)];
        axes.dedup();
        for axis in axes {
            let Some(direction) = whole.bases.chunks_exact(width).nth(axis) else { continue };
            // Cut through the mean across this component.
            let offset = dot(direction, &whole.mean);
            let side = |r: &u32| {
                let along: f64 = self.rows.row(*r).iter().zip(direction).map(|(x, d)| f64::from(*x) * d).sum();
                along > offset
            };
            let start = members.iter().map(side).collect();
            // Let both halves settle, and keep the better cut.
            let (error, second) = self.two_settled(members, start, components);
            if best.as_ref().is_none_or(|(least, _)| error < *least) {
                best = Some((error, second));
            }
        }
        best.filter(|(split, second)| *split < error && second.contains(&true) && second.contains(&false))
            .map(|(_, second)| second)
    }

    /// Lloyd's iteration among two halves of a cluster.
    fn two_settled(&self, members: &[u32], mut second: Vec<bool>, components: usize) -> (f64, Vec<bool>) {
        let mut scratch = Vec::new();
        let mut last = f64::INFINITY;
        for _ in 0..HALVING {
            let part = |of: bool| -> Vec<u32> {
                members.iter().zip(&second).filter(|(_, s)| **s == of).map(|(r, _)| *r).collect()
            };
            // Fit a subspace to each half.
            let spaces = [false, true].map(|of| Subspace::fit(self.rows, &part(of), components));
            // Give each row to the nearer of the two.
            let mut error = 0.0;
            let mut next = second.clone();
            for ((r, second), next) in members.iter().zip(&second).zip(&mut next) {
                let [a, b] = spaces.each_ref().map(|space| space.error(self.rows.row(*r), &mut scratch));
                error += if *second { b } else { a };
                *next = if *second { b <= a } else { b < a };
            }
            last = error;
            // End where no row moves or one half is empty.
            let (all, none) = (next.iter().all(|s| *s), next.iter().all(|s| !*s));
            if next == second || all || none {
                break;
            }
            second = next;
        }
        (last, second)
    }
}
