//! The upper side of μ*.
