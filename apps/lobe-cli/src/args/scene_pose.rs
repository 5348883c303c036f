//! Pose of a scene whose file moves: `--time` and `--animation`.

/// A time of an animation.
pub(crate) struct PoseInput {
    /// Seconds from the beginning, if a time is asked for.
    pub(crate) time: Option<f64>,
    /// The animation, by name or number.
    pub(crate) animation: Option<String>,
}

impl PoseInput {
    /// The first option that is given.
    pub(crate) fn asked(&self) -> Option<&'static str> {
        let time = self.time.map(|_| "--time");
        time.or(self.animation.as_ref().map(|_| "--animation"))
    }

    /// The time that is asked for, or else the beginning.
    pub(crate) fn seconds(&self) -> f64 {
        self.time.unwrap_or(0.0)
    }
}
