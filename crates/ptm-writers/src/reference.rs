//! Reference writer: generates the file for a request, in the spelling that every known reader accepts.

use crate::request::WriteRequest;
use ptm::Format;
use ptm_generate::plan::{Compression, Residuals};
use ptm_generate::{Model, Recipe, write};

/// Reason why a file was not written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotWritten {
    /// No file can represent the values; exit status 65.
    Impossible(String),
    /// The reference cannot write the file; exit status 69.
    Unsupported(String),
}

/// Writes the file for a request.
///
/// # Errors
/// Returns the reason why the file cannot be written.
pub fn write_requested_file(request: &WriteRequest) -> Result<Vec<u8>, NotWritten> {
    let recipe = recipe(request)?;
    let model = Model::new(&recipe, &request.samples)
        .map_err(|error| NotWritten::Impossible(error.to_string()))?;
    Ok(write(&recipe, &model).bytes)
}

/// Converts a request to a recipe for the generator.
///
/// # Errors
/// Returns the reason why the reference cannot write the file.
pub fn recipe(request: &WriteRequest) -> Result<Recipe, NotWritten> {
    let WriteRequest { header, format, .. } = request;
    let mut recipe = Recipe::default_for(*format, request.size());
    let numbers = "formatted numbers can be parsed";
    let (scale, bias) = (
        header.scale.map(format_decimal),
        header.bias.map(|bias| bias.to_string()),
    );
    recipe.scale = scale.join(" ").parse().expect(numbers);
    recipe.bias = bias.join(" ").parse().expect(numbers);
    if let Some(matrix) = header.matrix {
        recipe.matrix = matrix.map(format_decimal).join(" ").parse().expect(numbers);
    }
    if format.coding().is_some() {
        recipe.compression = compression(request, *format)?;
    }
    recipe
        .check()
        .map_err(|error| NotWritten::Unsupported(error.to_string()))?;
    Ok(recipe)
}

fn compression(request: &WriteRequest, format: Format) -> Result<Compression, NotWritten> {
    let header = &request.header;
    let mut plan = Compression::default_for(format);
    plan.parameter = header.quality.or(header.near).unwrap_or_default();
    plan.residuals = Residuals::Natural;
    if let Some(prediction) = &header.prediction {
        plan.references.clone_from(&prediction.references);
        plan.order.clone_from(&prediction.order);
        plan.transforms.clone_from(&prediction.transforms);
        plan.motion_x.clone_from(&prediction.motion_x);
        plan.motion_y.clone_from(&prediction.motion_y);
        let channels = format.channels();
        if [plan.references.len(), plan.order.len()] != [channels; 2] {
            let says = format!("every prediction list of {format} must have {channels} numbers");
            return Err(NotWritten::Impossible(says));
        }
    }
    Ok(plan)
}

/// Formats a number with all significant digits. Uses an exponent only for very small and very large numbers.
fn format_decimal(number: f64) -> String {
    match number.abs() {
        0.0 | 1e-20..1e20 => number.to_string(),
        _ => format!("{number:e}"),
    }
}
