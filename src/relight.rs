//! A page on which a map can be relit: one file that needs no network, with a still image for browsers without scripts.

use data_encoding::BASE64;
use image::ImageFormat;
use maud::{Markup, Render, html};
use serde_json::json;

use ptm::{ColorMatrix, Ptm, Shape, Size};
use ptm_files::render::{LIGHT, encode_image, render_lit, thin_out};

/// Maximum number of texels on the page. Of a larger map, only some rows and columns are shown.
const MAX_TEXELS: u64 = 1 << 20;

/// Maximum side of a map whose texels are shown as squares.
const MAX_SMALL_SIDE: u32 = 64;

/// Template of the page.
const TEMPLATE: &str = include_str!("relight.html");

/// Returns the page for a map. `name` is its title.
///
/// # Errors
/// Returns a message if the still image cannot be encoded.
pub fn page(ptm: &Ptm, name: &str) -> Result<String, String> {
    let whole = ptm.planes.size;
    let step = step_for(whole);
    let ptm = thin_out(ptm, step);
    let (Size { width, height }, set) = (ptm.planes.size, &ptm.header.scale_bias);
    let (lu, lv) = LIGHT;
    let still = encode_image(
        &render_lit(&ptm.coefficients(), lu, lv).into(),
        ImageFormat::Png,
    )?;
    let matrix = match ptm.planes.shape {
        Shape::Lum(ColorMatrix(elements)) => elements.to_vec(),
        _ => Vec::new(),
    };
    let map = json!({
        "width": width,
        "height": height,
        "channels": ptm.planes.shape.channels(),
        "scale": set.scale,
        "bias": set.bias,
        "matrix": matrix,
        "planes": BASE64.encode(&ptm.planes.samples),
    });
    let facts = facts(&ptm, whole, step);
    let rendering = match whole.width.max(whole.height) <= MAX_SMALL_SIDE {
        true => "pixelated",
        false => "auto",
    };
    // The text that is inserted last may contain anything.
    let page = TEMPLATE.replace("{rendering}", rendering);
    let page = page.replace("{still}", &BASE64.encode(&still));
    let page = page.replace("{map}", &map.to_string());
    let page = page.replace("{facts}", &facts.into_string());
    Ok(page.replace("{title}", &name.render().into_string()))
}

fn facts(ptm: &Ptm, whole: Size, step: u32) -> Markup {
    let numbers = |numbers: [f64; 6]| numbers.map(|number| number.to_string()).join(" ");
    let set = &ptm.header.scale_bias;
    html! {
        dt { "Format" } dd { (ptm.header.format.name()) }
        dt { "Size" } dd {
            (whole.width) " × " (whole.height) " texels"
            @if step > 1 { "; one in " (step) " rows and columns is shown" }
        }
        dt { "Scale" } dd { (numbers(set.scale)) }
        dt { "Bias" } dd { (numbers(set.bias)) }
    }
}

/// Returns the smallest n for which every n-th row and column have at most [`MAX_TEXELS`] texels.
fn step_for(size: Size) -> u32 {
    let mut steps = 1..;
    let fits = |step: &u32| {
        let sides = [size.width, size.height].map(|side| u64::from(side.div_ceil(*step)));
        sides[0] * sides[1] <= MAX_TEXELS
    };
    steps.find(fits).expect("a large step leaves one texel")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_maps_are_thinned_out() {
        for (width, height, step) in [
            (1, 1, 1),
            (1024, 1024, 1),
            (1025, 1024, 2),
            (u32::MAX, 1, 4096),
        ] {
            assert_eq!(step_for(Size { width, height }), step);
        }
    }
}
