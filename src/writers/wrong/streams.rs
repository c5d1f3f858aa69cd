//! Compressed planes written for a reader who predicts, corrects, sizes or places them in another way.
//!
//! The lists of 2.9 stay as they are; what they say to such a reader is asked of the misreading itself, and planes are
//! predicted from what that reader will have. So the file is right for it, whatever the mistake.

use std::array;

use crate::codec::{Encoded, jpeg, jpeg_ls};
use crate::generate::{Model, Recipe, write};
use crate::misreadings::{At, Misreading};
use crate::parts::{Coded, Number, Plan, PlaneStream, RawLists, Record};
use crate::reading::Reading;
use crate::writers::lossy::stored_plane;
use crate::writers::reference::recipe;
use crate::writers::request::WriteRequest;
use crate::writers::wrong::samples::with_samples;

/// Files that a writer with this mistake may write.
pub(super) fn candidates(
    request: &WriteRequest,
    right: &[u8],
    mistake: &Misreading,
) -> Vec<Vec<u8>> {
    let Ok(recipe) = recipe(request) else {
        return Vec::new();
    };
    if !request.format.is_compressed() {
        return Vec::new();
    }
    let reading = mistake.at.change(Reading::SPEC);
    let coder = Coder {
        request,
        recipe,
        reading,
    };
    let other = match mistake.at {
        At::Stream(stream) => coder.of_streams(stream),
        At::Reconstruct(_) => coder.solved(right).into_iter().collect(),
        _ => coder.encoded(right).into_iter().collect(),
    };
    let of_records = matches!(
        mistake.at,
        At::Records(_) | At::Correct(_) | At::SideInformation(_) | At::Reconstruct(_)
    );
    match of_records && request.is_lossy() {
        true => [other, coder.other_records()].concat(),
        false => other,
    }
}

/// What encodes for a reader.
struct Coder<'a> {
    request: &'a WriteRequest,
    recipe: Recipe,
    reading: Reading,
}

/// A plane as it is stored.
struct CodedPlane {
    stream: Vec<u8>,
    side: Vec<u8>,
}

/// What a reader has of a plane.
type Decoded = Option<Vec<u8>>;

impl Coder<'_> {
    fn count(&self) -> usize {
        self.request.format.channels()
    }

    /// The lists as they stand in the file.
    fn lists(&self, sizes: &[usize], side_sizes: &[usize]) -> RawLists {
        let plan = &self.recipe.compression;
        let number = |value: i64| Number { value, at: 0 };
        let vectors = plan.motion_x.iter().chain(&plan.motion_y);
        let lengths = |sizes: &[usize]| sizes.iter().map(|&size| number(size as i64)).collect();
        RawLists {
            format: self.request.format,
            parameter: number(i64::from(plan.parameter)),
            transforms: plan
                .transforms
                .iter()
                .map(|&one| number(i64::from(one)))
                .collect(),
            motion: vectors.map(|&one| number(i64::from(one))).collect(),
            order: plan.order.iter().map(|&one| number(one)).collect(),
            references: plan.references.iter().map(|&one| number(one)).collect(),
            sizes: lengths(sizes),
            side_sizes: lengths(side_sizes),
        }
    }

    fn plan(&self, sizes: &[usize], side_sizes: &[usize]) -> Option<Plan> {
        let plan = (self.reading.plan)(&self.lists(sizes, side_sizes)).ok()?;
        (plan.steps.len() == self.count() && plan.extents.len() == self.count()).then_some(plan)
    }

    fn targets(&self) -> Vec<Vec<u8>> {
        let planes = 0..self.count();
        planes
            .map(|plane| stored_plane(self.request, &self.request.samples, plane))
            .collect()
    }

    /// The file of planes that are predicted as the reader predicts.
    fn encoded(&self, right: &[u8]) -> Option<Vec<u8>> {
        let none = vec![0; self.count()];
        let plan = self.plan(&none, &none)?;
        let targets = self.targets();
        let mut decoded: Vec<Decoded> = vec![None; self.count()];
        let mut coded: Vec<Option<CodedPlane>> = (0..self.count()).map(|_| None).collect();
        for &i in &plan.sequence {
            let predictor = match plan.steps[i].reference {
                None => None,
                Some(reference) => {
                    let reference = decoded.get(reference)?.as_ref()?;
                    let size = self.request.size();
                    Some(
                        (self.reading.predictor)(reference, &plan.steps[i], size, &self.reading)
                            .into_owned(),
                    )
                }
            };
            let (plane, samples) = self.coded_plane(&targets[i], predictor.as_deref())?;
            decoded[i] = Some(samples);
            coded[i] = Some(plane);
        }
        let coded: Vec<CodedPlane> = coded.into_iter().collect::<Option<_>>()?;
        self.laid_out(right, &coded, &plan.sequence)
    }

    /// A plane as it is stored, and as the reader has it.
    fn coded_plane(
        &self,
        target: &[u8],
        predictor: Option<&[u8]>,
    ) -> Option<(CodedPlane, Vec<u8>)> {
        let predict = match self.request.format.is_jpeg_ls() {
            true => self.reading.predict_jpeg_ls,
            false => self.reading.predict,
        };
        let residual = match predictor {
            None => target.to_vec(),
            Some(predictor) => residuals(predict, target, predictor),
        };
        let Encoded { stream, samples } = self.encode(&residual);
        let mut restored = samples;
        if let Some(predictor) = predictor {
            predict(&mut restored, predictor);
        }
        let lossless = !self.request.is_lossy();
        let is_off = |place: &usize| match lossless {
            true => target[*place] != restored[*place],
            false => target[*place].abs_diff(restored[*place]) > 128,
        };
        let records: Vec<Record> = (0..target.len())
            .filter(is_off)
            .map(|place| Some((place as u32, self.value(restored[place], target[place])?)))
            .collect::<Option<_>>()?;
        let side = self.side_information(&records, target.len())?;
        (self.reading.correct)(&mut restored, &records);
        Some((CodedPlane { stream, side }, restored))
    }

    /// The value of a record that makes `target` of `restored`.
    fn value(&self, restored: u8, target: u8) -> Option<u8> {
        let makes = |value: &u8| {
            let mut plane = [restored];
            (self.reading.correct)(&mut plane, &[(0, *value)]);
            plane[0] == target
        };
        [target].into_iter().chain(0..=255).find(makes)
    }

    /// Records as the reader takes them apart.
    fn side_information(&self, records: &[Record], texels: usize) -> Option<Vec<u8>> {
        let whole = |layout: &fn(u32, u8) -> Vec<u8>| -> Vec<u8> {
            records
                .iter()
                .flat_map(|&(position, value)| layout(position, value))
                .collect()
        };
        let means_it = |block: &Vec<u8>| {
            (self.reading.records)(block, 0, texels).is_ok_and(|read| read == records)
        };
        let plain = LAYOUTS.iter().map(whole);
        let longer = LAYOUTS[..1].iter().map(whole).flat_map(|block| {
            let ends = (
                block.get(..5),
                block.len().checked_sub(5).and_then(|at| block.get(at..)),
            );
            match ends {
                (Some(first), Some(last)) => {
                    vec![[first, &block].concat(), [&block, last].concat()]
                }
                _ => Vec::new(),
            }
        });
        plain.chain(longer).find(means_it)
    }

    fn encode(&self, residual: &[u8]) -> Encoded {
        let (width, height) = (self.request.header.width, self.request.header.height);
        let parameter = self.recipe.compression.parameter;
        if self.request.format.is_jpeg() {
            return jpeg::encode(residual, width, height, &jpeg::JpegOptions::new(parameter));
        }
        let options = jpeg_ls::JpegLsOptions {
            near: parameter,
            presets: None,
        };
        jpeg_ls::encode(residual, width, height, &options)
    }

    /// The file, with sizes that lead the reader to every stream.
    fn laid_out(&self, right: &[u8], coded: &[CodedPlane], sequence: &[usize]) -> Option<Vec<u8>> {
        let streams: Vec<usize> = coded.iter().map(|plane| plane.stream.len()).collect();
        let sides: Vec<usize> = coded.iter().map(|plane| plane.side.len()).collect();
        let both: Vec<usize> = streams
            .iter()
            .zip(&sides)
            .map(|(stream, side)| stream + side)
            .collect();
        let counted: Vec<usize> = sides.iter().map(|side| side / 5).collect();
        let ranked =
            |sizes: &[usize]| -> Vec<usize> { sequence.iter().map(|&i| sizes[i]).collect() };
        let ways = [
            (streams.clone(), sides.clone()),
            (both, sides.clone()),
            (streams.clone(), counted),
            (ranked(&streams), ranked(&sides)),
        ];
        ways.into_iter().find_map(|(sizes, side_sizes)| {
            let plan = self.plan(&sizes, &side_sizes)?;
            let payload = payload(&plan, coded)?;
            Some(self.file(right, &sizes, &side_sizes, &payload))
        })
    }

    /// The header of the right file, the lists, the planes.
    fn file(&self, right: &[u8], sizes: &[usize], side_sizes: &[usize], payload: &[u8]) -> Vec<u8> {
        let lists = self.lists(sizes, side_sizes);
        let line = |numbers: &[Number]| {
            let numbers: Vec<String> = numbers
                .iter()
                .map(|number| number.value.to_string())
                .collect();
            numbers.join(" ") + "\n"
        };
        let (x, y) = lists.motion.split_at(self.count());
        let text = [
            line(&[lists.parameter]),
            line(&lists.transforms),
            line(x),
            line(y),
            line(&lists.order),
            line(&lists.references),
            line(&lists.sizes),
            line(&lists.side_sizes),
        ];
        // Version, format, width, height, scales, biases.
        let lines = right.split_inclusive(|&byte| byte == b'\n').take(6);
        [
            &lines.flatten().copied().collect::<Vec<u8>>(),
            text.concat().as_bytes(),
            payload,
        ]
        .concat()
    }

    /// Residuals of which the reader makes the planes, found by repair: what it makes too little is added.
    fn solved(&self, right: &[u8]) -> Option<Vec<u8>> {
        if self.request.is_lossy() {
            return None;
        }
        let none = vec![0; self.count()];
        let plan = self.plan(&none, &none)?;
        let coded = Coded {
            format: self.request.format,
            size: self.request.size(),
            plan: &plan,
            at: 0,
            payload: &[],
        };
        let targets = self.targets();
        let found = [u8::wrapping_add as fn(u8, u8) -> u8, u8::wrapping_sub]
            .into_iter()
            .find_map(|repair| {
                let mut residuals: Vec<Vec<u8>> =
                    plan.sequence.iter().map(|&i| targets[i].clone()).collect();
                for _ in 0..self.count() + 2 {
                    let planes =
                        (self.reading.reconstruct)(&coded, residuals.clone(), &self.reading)
                            .ok()?;
                    if planes == targets {
                        return Some(residuals);
                    }
                    for (residual, &i) in residuals.iter_mut().zip(&plan.sequence) {
                        for ((residual, made), wanted) in
                            residual.iter_mut().zip(planes.get(i)?).zip(&targets[i])
                        {
                            *residual = repair(*residual, wanted.wrapping_sub(*made));
                        }
                    }
                }
                None
            })?;
        let mut planes: Vec<Option<CodedPlane>> = (0..self.count()).map(|_| None).collect();
        for (residual, &i) in found.iter().zip(&plan.sequence) {
            planes[i] = Some(CodedPlane {
                stream: self.encode(residual).stream,
                side: Vec::new(),
            });
        }
        let planes: Vec<CodedPlane> = planes.into_iter().collect::<Option<_>>()?;
        self.laid_out(right, &planes, &plan.sequence)
    }

    /// The right streams with other records.
    fn other_records(&self) -> Vec<Vec<u8>> {
        let Ok(model) = Model::of(&self.recipe, &self.request.samples) else {
            return Vec::new();
        };
        let (width, height) = (self.request.header.width, self.request.header.height);
        let edited = POSITIONS.iter().map(|edit| {
            let mut model = model.clone();
            let planes = model
                .compressed
                .iter_mut()
                .flat_map(|compressed| &mut compressed.planes);
            for plane in planes {
                for (position, _) in &mut plane.records {
                    *position = edit(*position, width, height);
                }
            }
            write(&self.recipe, &model).bytes
        });
        let kept = KEPT.iter().map(|keeps| {
            let mut model = model.clone();
            let plan = &self.recipe.compression;
            let planes = model
                .compressed
                .iter_mut()
                .flat_map(|compressed| &mut compressed.planes);
            for (i, plane) in planes.enumerate() {
                if !keeps(i, plan.reference(i).is_some(), plan.transforms[i]) {
                    plane.records.clear();
                }
            }
            write(&self.recipe, &model).bytes
        });
        edited.chain(kept).collect()
    }

    /// Values of which the reader's streams make the right ones: mirrored, or through a curve.
    fn of_streams(
        &self,
        stream: fn(&PlaneStream) -> crate::error::Result<Vec<u8>>,
    ) -> Vec<Vec<u8>> {
        let channels = self.count();
        let row = self.request.header.width as usize * channels;
        let rows = self.request.samples.chunks_exact(row);
        let mirrored = rows.flat_map(|row| row.chunks_exact(channels).rev().flatten());
        let mirrored = with_samples(self.request, mirrored.copied().collect());
        let curved = self.curve(stream).and_then(|curve| {
            let values = self
                .request
                .samples
                .iter()
                .map(|&value| curve[usize::from(value)]);
            with_samples(self.request, values.collect())
        });
        mirrored.into_iter().chain(curved).collect()
    }

    /// For each value the one that the reader takes for it.
    fn curve(
        &self,
        stream: fn(&PlaneStream) -> crate::error::Result<Vec<u8>>,
    ) -> Option<[u8; 256]> {
        let texels = self.request.size().texels();
        let mut made = [0; 256];
        for (value, made) in made.iter_mut().enumerate() {
            let bytes = self.encode(&vec![value as u8; texels]).stream;
            let plane = PlaneStream {
                format: self.request.format,
                plane: 0,
                at: 0,
                bytes: &bytes,
                size: self.request.size(),
            };
            *made = *stream(&plane).ok()?.first()?;
        }
        Some(array::from_fn(|wanted| nearest(&made, wanted as u8)))
    }
}

/// Ways to write a record.
const LAYOUTS: [fn(u32, u8) -> Vec<u8>; 9] = [
    |position, value| [&position.to_be_bytes()[..], &[value]].concat(),
    |position, value| [&position.to_le_bytes()[..], &[value]].concat(),
    |position, value| [&position.rotate_left(16).to_be_bytes()[..], &[value]].concat(),
    |position, value| [&[value], &position.to_be_bytes()[..]].concat(),
    |position, value| [&position.to_be_bytes()[1..], &[value]].concat(),
    |position, value| [&(position + 1).to_be_bytes()[..], &[value]].concat(),
    |position, value| [&position.wrapping_sub(1).to_be_bytes()[..], &[value]].concat(),
    |position, value| [&position.to_be_bytes()[..], &[value], &[0; 4]].concat(),
    |position, value| [&[value], &position.to_le_bytes()[..]].concat(),
];

/// Ways to count texels: a position in the stored raster, width, height.
const POSITIONS: [fn(u32, u32, u32) -> u32; 6] = [
    |position, width, height| (height - 1 - position / width) * width + position % width,
    |position, width, height| position % width * height + position / width,
    |position, width, _| position / width * width + width - 1 - position % width,
    |position, width, height| width * height - 1 - position,
    |position, _, _| position + 1,
    |position, _, _| position.saturating_sub(1),
];

/// Which planes have their records: number, whether it is predicted, transform.
const KEPT: [fn(usize, bool, u32) -> bool; 5] = [
    |_, _, _| false,
    |_, is_predicted, _| is_predicted,
    |_, is_predicted, _| !is_predicted,
    |_, _, transform| transform == 0,
    |plane, _, _| plane < 6,
];

/// What gives `target` when `predict` adds it to `predictor`, as nearly as there is such a value.
fn residuals(predict: fn(&mut [u8], &[u8]), target: &[u8], predictor: &[u8]) -> Vec<u8> {
    let mut tables: Vec<Option<[u8; 256]>> = vec![None; 256];
    let pairs = target.iter().zip(predictor);
    pairs
        .map(|(&target, &predictor)| {
            let table = tables[usize::from(predictor)].get_or_insert_with(|| {
                let mut made: [u8; 256] = array::from_fn(|residual| residual as u8);
                predict(&mut made, &[predictor; 256]);
                let mut exact = [None; 256];
                for (residual, made) in made.iter().enumerate().rev() {
                    exact[usize::from(*made)] = Some(residual as u8);
                }
                array::from_fn(|wanted| {
                    exact[wanted].unwrap_or_else(|| nearest(&made, wanted as u8))
                })
            });
            table[usize::from(target)]
        })
        .collect()
}

/// The first place of the value that is nearest to `wanted`.
fn nearest(values: &[u8; 256], wanted: u8) -> u8 {
    let off = |place: &usize| values[*place].abs_diff(wanted);
    (0..256).min_by_key(off).unwrap_or_default() as u8
}

/// The planes where the reader looks for them, if they do not overlap.
fn payload(plan: &Plan, coded: &[CodedPlane]) -> Option<Vec<u8>> {
    let total = coded
        .iter()
        .map(|plane| plane.stream.len() + plane.side.len())
        .sum();
    let mut payload = vec![0; total];
    let mut filled = vec![false; total];
    for (extent, plane) in plan.extents.iter().zip(coded) {
        for (range, bytes) in [(&extent.stream, &plane.stream), (&extent.side, &plane.side)] {
            if range.len() != bytes.len() {
                return None;
            }
            payload.get_mut(range.clone())?.copy_from_slice(bytes);
            let mut taken = filled.get_mut(range.clone())?.iter_mut();
            if taken.any(|taken| std::mem::replace(taken, true)) {
                return None;
            }
        }
    }
    Some(payload)
}
