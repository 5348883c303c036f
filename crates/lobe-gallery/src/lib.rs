//! Pictures of everything that Lobe does, on built-in data: the page of `lobe demo`, and those of the documents.
//!
//! [`write_gallery`] writes a folder with a page of sections. Each section has a title, words, pictures and tables, whose
//! numbers are measured, and a command that does the same to data of the reader. [`document_pictures`] draws those that
//! the documents have too.
//!
//! Read `gallery` first, the table of all sections, then `page`, on which they draw. Sections about a photograph are in
//! `photographs`, about functions on the sphere in `functions`, about scenes in `scenes`.
//!
//! ```no_run
//! use lobe::io::Job;
//! use lobe_gallery::{Size, write_gallery};
//!
//! let page = write_gallery("demo".as_ref(), Size::QUICK, Job::default())?;
//! println!("{}", page.display());
//! # Ok::<(), lobe_gallery::GalleryError>(())
//! ```

mod documents;
mod error;
mod functions;
mod gallery;
mod page;
mod photographs;
mod scenes;

pub use documents::document_pictures;
pub use error::GalleryError;
pub use gallery::{page_in, write_gallery};
pub use page::Size;
