//! Environment maps: pictures of everything around a point.
