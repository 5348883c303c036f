//! The scene that is left while another one is being opened.

use lobe::motion::MovingMethod;

use crate::rooms::motion::cast::{Cast, Hand};
use crate::rooms::motion::player::{Asked, Player, Shown, Source};
use crate::widgets::orbit::Orbit;

/// All that belongs to the scene, so that it is there again where the other one fails or is taken back.
pub(crate) struct Before {
    pub(crate) source: Source,
    /// None where the scene is to be opened again.
    pub(crate) player: Option<Player>,
    pub(crate) cast: Cast,
    pub(crate) in_hand: InHand,
    pub(crate) asked: Option<Asked>,
    pub(crate) lit: Option<Shown>,
    pub(crate) orbit: Orbit,
    pub(crate) is_waiting: bool,
    pub(crate) is_stopped: bool,
}

/// Where a user has put the parts of a scene, whether they are there, and which is chosen.
#[derive(Clone, Debug, Default)]
pub(crate) struct InHand {
    pub(crate) hands: Vec<Hand>,
    pub(crate) is_by_hand: bool,
    pub(crate) chosen: usize,
}

impl Before {
    /// The same without bakes under way, which would take their time from those of the other scene: what is lit is asked for again, which
    /// needs none; where nothing is, the bakes end with their player.
    pub(crate) fn at_rest(mut self) -> Self {
        match (&self.lit, &self.player) {
            (Some(lit), Some(player)) if self.is_waiting => {
                let mut asked = lit.asked_as_lit();
                // Spheres of another fit are forgotten: asking for them would fit them anew.
                let is_kept = self.asked.as_ref().is_none_or(|asked| asked.fit == lit.asked.fit);
                asked.methods.retain(|&method| is_kept || method != MovingMethod::Exponentials);
                player.ask(asked.clone());
                self.asked = Some(asked);
            }
            (None, Some(player)) if player.task().is_at_work() && !self.is_stopped => self.player = None,
            _ => {}
        }
        self
    }
}
