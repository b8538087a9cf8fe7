//! `slice`: a map out of a store of more than two axes.

use std::path::PathBuf;

use clap::Args;

use super::json::JsonArgs;
use super::outputs::{self, Outputs};
use super::{Failure, request, words};
use crate::design::Coordinate;
use crate::measure::Quantity;
use crate::picture::Style;
use crate::store::Store;

#[derive(Args)]
pub struct SliceArgs {
    /// The store, NAME.zarr
    store: PathBuf,
    /// Horizontal axis
    #[arg(long, value_name = "NAME", value_parser = coordinate)]
    x: Coordinate,
    /// Vertical axis
    #[arg(long, value_name = "NAME", value_parser = coordinate)]
    y: Coordinate,
    /// Value of another axis, one that the store has; needed for each
    #[arg(long, value_name = "NAME=VALUE", value_parser = request::assignment)]
    at: Vec<(Coordinate, f64)>,
    /// Quantity to draw; may be repeated [default: lyapunov, period and the border's CSV]
    #[arg(long, value_name = "NAME", value_parser = request::named::<Quantity>)]
    quantity: Vec<Quantity>,
    /// What all output names begin with [default: outputs/slice]
    #[arg(long, value_name = "NAME")]
    out: Option<PathBuf>,
    /// Replace pictures of another experiment
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    json: JsonArgs,
}

fn coordinate(text: &str) -> Result<Coordinate, String> {
    Coordinate::from_name(text).map_err(|error| error.to_string())
}

pub fn run(args: &SliceArgs) -> Result<(), Failure> {
    let store = Store::open(&args.store).map_err(Failure::input)?;
    let map = store.slice([args.x, args.y], &args.at).map_err(Failure::input)?;
    outputs::check_held(&map, &args.quantity, &args.store).map_err(Failure::Input)?;
    if args.json.wanted() && args.out.is_none() {
        args.json.print(&words::object(&map));
        return Ok(());
    }
    let outputs = Outputs::new(args.out.as_deref().unwrap_or("outputs/slice".as_ref()));
    if !args.force {
        outputs.check_pictures(&map.experiment).map_err(Failure::Input)?;
    }
    outputs.draw_and_tell(&map, &args.quantity, &Style::default(), args.json)
}
