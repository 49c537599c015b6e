//! What hides what is behind it.

mod occluders;
