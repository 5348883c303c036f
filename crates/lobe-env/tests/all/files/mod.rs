//! Map files: what a file says of its mapping, and the same map through every format.
mod envmap;
mod fisheye;
mod maps;
mod panoramas;
mod project_file;
