//! The files that the program writes are judged like those of other writers.

use ptm_conform::decode;
use ptm_conform::generate::{Model, Recipe, write};
use ptm_conform::ptm::Format;
use ptm_conform::suite::cases::{Expect, Suite};
use ptm_conform::tools::convert::{Target, convert};
use ptm_conform::tools::dissection::Dissection;
use ptm_conform::writers::judge::judge;
use ptm_conform::writers::request::{RequestHeader, WriteRequest};

/// Makes a request of the values of a recipe.
fn request(recipe: &Recipe, model: &Model) -> WriteRequest {
    let format = recipe.format;
    let parameter = recipe.compression.parameter;
    WriteRequest {
        header: RequestHeader {
            format: format.name().to_owned(),
            width: recipe.size.width,
            height: recipe.size.height,
            scale: recipe.scale.values,
            bias: recipe.bias.values.map(|bias| bias as i64),
            matrix: (format == Format::Lum).then_some(recipe.matrix.values),
            quality: format.is_jpeg().then_some(parameter),
            near: format.is_jpeg_ls().then_some(parameter),
            prediction: None,
            planes: String::new(),
        },
        format,
        samples: model.samples.clone(),
    }
}

#[test]
fn generated_files_have_the_values_that_were_painted() {
    let suite = Suite::load().expect("the suite loads");
    let mut judged = 0;
    for case in suite.cases.iter().step_by(5) {
        let small = |recipe: &&Recipe| recipe.size.texels() <= 400 && recipe.entries <= 300;
        let (Some(recipe), None, Expect::Decode) =
            (case.recipe().filter(small), case.damage(), case.expect)
        else {
            continue;
        };
        let model = Model::paint(recipe);
        let file = write(recipe, &model).bytes;
        let asked = request(recipe, &model);
        assert_eq!(judge(&asked, &file), Ok(()), "{}", case.id);
        judged += 1;
    }
    assert!(judged >= 50, "{judged} files");
}

#[test]
fn converted_files_have_the_values_of_their_source() {
    let size = "5x4".parse().expect("a size");
    let mut judged = 0;
    for from in Format::ALL {
        let recipe = Recipe::ordinary(from, size);
        let file = write(&recipe, &Model::paint(&recipe)).bytes;
        let ptm = decode(&file).expect("a map");
        for to in Format::ALL {
            let target = Target {
                format: to,
                quality: to.is_jpeg().then_some(90),
                loss: 0,
            };
            let converted = convert(&Dissection::of(&file), &ptm, target);
            let Ok(converted) = converted else { continue };
            // Between RGB and LRGB the stored values are others.
            if from.channels() != to.channels() {
                continue;
            }
            let mut asked = WriteRequest::of(&ptm);
            asked.format = to;
            to.name().clone_into(&mut asked.header.format);
            asked.header.quality = target.quality;
            asked.header.near = to.is_jpeg_ls().then_some(0);
            assert_eq!(judge(&asked, &converted.bytes), Ok(()), "{from} to {to}");
            judged += 1;
        }
    }
    assert!(judged >= 20, "{judged} conversions");
}
