//! `lobe env rotate`: rotation of a map.

use clap::Args;
use lobe::env::rotate_map;

use crate::args::map_input::{MapInput, OF_LARGER, OF_MAP, OF_SMALLER};
use crate::args::map_output::MapOutput;
use crate::args::turn::Turn;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct EnvRotate {
    #[command(flatten)]
    input: MapInput,
    #[command(flatten)]
    output: MapOutput,
    #[command(flatten)]
    turn: Turn,
}

impl EnvRotate {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let rotation = self.turn.rotation()?;
        let map = self.input.read(talk)?;
        self.output.check(map.mapping(), &self.input.files()?)?;
        let written = OF_MAP + self.output.bytes_of_texel(map.mapping());
        self.input.check_work("rotating", &map, written.max(OF_LARGER + OF_SMALLER))?;
        self.output.write(talk.watch("rotate", |job| rotate_map(&map, &rotation, job))?, talk)
    }
}
