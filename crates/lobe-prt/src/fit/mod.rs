//! Transfer at vertices as a least-squares fit to transfer at points all over the triangles.
//!
//! Read `vertex_fit` first: it has the equation, and bakes. `fitted_vertices` says which vertices and which side,
//! `face` is that side of one triangle; `surface_points` spreads points over the triangles around; `triangle_moments`
//! bakes the points, a row of sums for each triangle, less their `sampling_errors`; `normal_equations` puts the sums
//! together, `smoothness` adds the regularization across edges, and `conjugate_gradients` solves for all coefficients.
//! `residual` measures what no values at corners can fit, and `adaptive` splits triangles where that is most.
//! Uses `bake`, `receivers`, `sampling`, `transfer` and `job`.

pub(crate) mod adaptive;
pub(crate) mod conjugate_gradients;
pub(crate) mod face;
pub(crate) mod fitted_vertices;
pub(crate) mod normal_equations;
pub(crate) mod residual;
pub(crate) mod sampling_errors;
pub(crate) mod smoothness;
pub(crate) mod sparse_matrix;
pub(crate) mod surface_points;
pub(crate) mod triangle_moments;
pub(crate) mod vertex_fit;
