//! Engines that take a light: what each wants, and a map's light as the files that it reads.
//!
//! Read [`engine`] first, a table with one row for each engine, then [`export`], which makes the files
//! ([`exported_file`]) by [`export_options`]: pictures and cubes of one light ([`light_parts`]), numbers
//! ([`coefficients`]), and a program that loads them ([`snippet`], with [`read_me`] beside it; `usd_lights` for a
//! stage). [`import`] reads numbers of engines back. Uses `files`, `map`, `prefilter`, `projection`, `resample` and
//! `sky`.

pub(crate) mod coefficients;
pub(crate) mod engine;
pub(crate) mod export;
pub(crate) mod export_options;
pub(crate) mod exported_file;
pub(crate) mod import;
pub(crate) mod light_parts;
pub(crate) mod read_me;
pub(crate) mod snippet;
mod usd_lights;
