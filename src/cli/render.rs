//! `render`: pictures from a store, without computing.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;

use super::json::JsonArgs;
use super::outputs::{self, Outputs};
use super::overlay::{self, Theory};
use super::{Failure, request, words};
use crate::map::ParameterMap;
use crate::measure::Quantity;
use crate::picture::Style;
use crate::picture::colour::ColourScale;
use crate::store::Store;

#[derive(Args)]
pub struct RenderArgs {
    /// The store, NAME.zarr
    store: PathBuf,
    /// What all output names begin with [default: NAME]
    #[arg(long, value_name = "NAME")]
    out: Option<PathBuf>,
    /// Quantity to draw; may be repeated [default: lyapunov, period and the border's CSV]
    #[arg(long, value_name = "NAME", value_parser = request::named::<Quantity>)]
    quantity: Vec<Quantity>,
    /// Ends of the colour scale; with a machine in SI units: exponents in 1/s, pressure in Pa, temperature in K, wear in m and
    /// times in s [default: from the data]
    #[arg(long, value_name = "LOW:HIGH", value_parser = request::limits, allow_hyphen_values = true)]
    limits: Option<[f64; 2]>,
    /// Colours: blue-red or purple-green [default: blue-red]
    #[arg(long, value_name = "NAME", value_parser = colours)]
    colours: Option<ColourScale>,
    /// Leave out the border of chaos
    #[arg(long)]
    no_border: bool,
    /// Curve from theory over the pictures: melnikov, the threshold of Mel'nikov's criterion
    #[arg(long, value_name = "melnikov", value_parser = request::named::<Theory>)]
    overlay: Option<Theory>,
    /// Replace pictures of another experiment, or the map's own ones by those of another style
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    json: JsonArgs,
}

impl RenderArgs {
    /// Quantities that are drawn.
    fn quantities(&self, map: &ParameterMap) -> Vec<Quantity> {
        if self.quantity.is_empty() {
            Quantity::drawn(map.experiment.wears()).to_vec()
        } else {
            self.quantity.clone()
        }
    }

    /// # Errors
    /// If the map's own pictures would be replaced by others of another style.
    fn check_own_pictures(&self, map: &ParameterMap, outputs: &Outputs) -> anyhow::Result<()> {
        let is_own = self.out.is_none();
        let has_style = self.limits.is_some() || self.colours.is_some() || self.no_border || self.overlay.is_some();
        let pictures = self
            .quantities(map)
            .into_iter()
            .map(|quantity| outputs.picture(quantity));
        if is_own
            && has_style
            && let Some(picture) = pictures.into_iter().find(|picture| picture.exists())
        {
            bail!(
                "{} is the map's own picture, in another style: give --out a name, or --force to replace it",
                picture.display()
            );
        }
        Ok(())
    }
}

fn colours(name: &str) -> Result<ColourScale, String> {
    ColourScale::from_name(name).ok_or_else(|| {
        let known = ColourScale::ALL.map(ColourScale::name).join(", ");
        format!("unknown colours `{name}`: there are {known}")
    })
}

pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let name = outputs::name_of_store(&args.store).map_err(Failure::Input)?;
    let results = Store::open(&args.store).and_then(|store| store.read());
    let map = ParameterMap::try_from(results.map_err(Failure::input)?).map_err(Failure::input)?;
    outputs::check_held(&map, &args.quantity, &args.store).map_err(Failure::Input)?;
    if args.json.wanted() && args.out.is_none() {
        args.json.print(&words::object(&map));
        return Ok(());
    }
    let outputs = Outputs::new(args.out.as_deref().unwrap_or(&name));
    if !args.force {
        outputs.check_pictures(&map.experiment).map_err(Failure::Input)?;
        args.check_own_pictures(&map, &outputs).map_err(Failure::Input)?;
    }
    let mut style = Style {
        border: !args.no_border,
        overlay: overlay::curve(args.overlay, &map.experiment)?,
        ..Style::default()
    };
    style.limits = args.limits.map(|[low, high]| (low, high));
    style.colours = args.colours.unwrap_or(style.colours);
    outputs.draw_and_tell(&map, &args.quantity, &style, args.json)
}
