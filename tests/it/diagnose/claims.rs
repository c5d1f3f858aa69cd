//! Checks what a cause claims about the images listed under it, apart from the code that writes the sentences.
//!
//! `docs/diagnosis.md` says what each sentence claims.

use std::collections::BTreeSet;

use ptm::decode::examine_streams;
use ptm::{Format, Reading, channel_name};
use ptm_harness::report::document::LikelyCause;
use ptm_harness::session::run::Run;
use ptm_suite::cases::{Case, Expect, Suite};
use ptm_suite::choices::CHOICES;
use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::{Answer, Frame, ViewKind};
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::observation::Response;

/// A wrong image of a listed case.
struct WrongImage<'a> {
    case: &'a Case,
    expected: Expected,
    received: Frame,
    planes: Vec<Plane>,
}

/// How a plane of a compressed file is decoded.
struct Plane {
    reference: Option<usize>,
    /// Positions of the records. They count texels in stored order.
    corrected: BTreeSet<usize>,
}

/// Returns the planes of a compressed file; none if the file is not compressed.
fn planes_of(file: &[u8]) -> Vec<Plane> {
    let (_, _, Some(streams)) = examine_streams(file) else {
        return Vec::new();
    };
    let coded = streams.coded();
    let planes = coded.plan.steps.iter().zip(&coded.plan.extents);
    let planes = planes.map(|(step, extent)| {
        let records = coded.payload[extent.side.clone()].chunks_exact(5);
        let position = |record: &[u8]| {
            let bytes = record[..4].iter();
            bytes.fold(0, |all, &byte| all << 8 | usize::from(byte))
        };
        Plane {
            reference: step.reference,
            corrected: records.map(position).collect(),
        }
    });
    planes.collect()
}

impl WrongImage<'_> {
    fn channels(&self) -> usize {
        self.expected.channels
    }

    fn has_right_shape(&self) -> bool {
        let Frame { width, height, .. } = self.received;
        (width, height) == (self.expected.size.width, self.expected.size.height)
            && self.received.channels as usize == self.channels()
            && self.received.samples.sample_type() == self.expected.view.sample_type()
    }

    /// Returns the wrong samples of an image with the right shape.
    fn wrong_samples(&self) -> Vec<usize> {
        let is_wrong = |&i: &usize| !self.expected.is_near(i, self.received.samples.real(i));
        (0..self.expected.values.len()).filter(is_wrong).collect()
    }

    fn wrong_channels(&self) -> BTreeSet<usize> {
        let samples = self.wrong_samples().into_iter();
        samples.map(|i| i % self.channels()).collect()
    }

    /// Returns the column and the row, from the top left.
    fn texel(&self, i: usize) -> (usize, usize) {
        let (texel, width) = (i / self.channels(), self.expected.size.width as usize);
        (texel % width, texel / width)
    }

    fn is_corrected(&self, i: usize) -> bool {
        let (x, y) = self.texel(i);
        let (width, height) = (self.expected.size.width, self.expected.size.height);
        let stored = (height as usize - 1 - y) * width as usize + x;
        let plane = &self.planes[i % self.channels()];
        plane.corrected.contains(&stored)
    }

    /// Returns true if all wrong samples satisfy `is_there` or are in a plane predicted from a wrong plane.
    fn are_there_or_predicted(&self, is_there: impl Fn(usize) -> bool) -> bool {
        let wrong = self.wrong_channels();
        let samples = self.wrong_samples().into_iter();
        let mut left = samples.filter(|&i| {
            let reference = self.planes[i % self.channels()].reference;
            !is_there(i) && !reference.is_some_and(|reference| wrong.contains(&reference))
        });
        left.next().is_none()
    }

    /// Returns true if some wrong plane is not predicted and, if `plain`, not corrected.
    fn has_wrong_plane(&self, plain: bool) -> bool {
        self.wrong_channels().into_iter().any(|plane| {
            let plane = &self.planes[plane];
            plane.reference.is_none() && (!plain || plane.corrected.is_empty())
        })
    }

    fn is_rearranged(&self) -> bool {
        let sorted = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values
        };
        sorted(self.expected.frame().samples.to_reals()) == sorted(self.received.samples.to_reals())
    }
}

/// Returns the names under which a sentence may list a channel.
fn names(channels: usize, channel: usize) -> Vec<String> {
    let color = |c: usize| ["red", "green", "blue"][c].to_owned();
    let mut names = vec![channel_name(channels, channel)];
    match (channels, channel) {
        (18, _) => names.extend([format!("a{}", channel % 6), color(channel / 6)]),
        (8 | 9, 6..) => {
            names.push("the channels after a5".to_owned());
            names.extend((channel == 6).then(|| "the first channel after a5".to_owned()));
            names.extend((channels == 9).then(|| color(channel - 6)));
        }
        _ => {}
    }
    names
}

/// Returns true if a texel of an image of this size is in a place with this name.
fn is_in(place: &str, (x, y): (usize, usize), width: usize, height: usize) -> Option<bool> {
    Some(match place {
        "in the first stored texel" => (x, y) == (0, height - 1),
        "in the last stored texel" => (x, y) == (width - 1, 0),
        "in the bottom row" => y == height - 1,
        "in the top row" => y == 0,
        "in the left column" => x == 0,
        "in the right column" => x == width - 1,
        _ => return None,
    })
}

/// Returns the wrong images of the cases listed under a cause.
fn wrong_images<'a>(
    cause: &LikelyCause,
    suite: &'a Suite,
    run: &Run,
    reading: &Reading,
    decoder: &impl Fn(&Request) -> Answer,
) -> Vec<WrongImage<'a>> {
    let image = |id: &String| {
        let i = suite.cases.iter().position(|case| case.id == *id)?;
        let (case, view) = (&suite.cases[i], &run.observations[i].as_ref()?.view);
        let built = case.build(run.table);
        let Answer::Decoded(received) = decoder(&Request::new(id, view, &built.file, 1 << 24))
        else {
            return None;
        };
        let own = Expected::from_file(&built.file, view, reading);
        let model = Expected::new(&built.values, view);
        // The tolerance for different inverse DCTs is known only in the reference's dialect.
        let expected = match (own, model) {
            (Some(own), Some(model)) if own.frame() == model.frame() => model,
            (own, model) => own.or(model)?,
        };
        Some(WrongImage {
            case,
            expected,
            received,
            planes: planes_of(&built.file),
        })
    };
    cause.explains.iter().filter_map(image).collect()
}

/// Returns what follows `words` in a text.
fn after<'a>(text: &'a str, words: &str) -> Option<&'a str> {
    text.split_once(words).map(|(_, rest)| rest)
}

/// Returns the number at the start of a text.
fn number(text: &str) -> Option<f64> {
    let end = text.find([',', ' ', ';']).unwrap_or(text.len());
    text[..end].parse().ok()
}

/// Returns true if a printed value may stand for this one.
fn is_printed(text: f64, value: f64) -> bool {
    text.is_nan() && value.is_nan()
        || text == value
        || (text - value).abs() <= 1e-4_f64.max(value.abs() / 19.0 * f64::from(value.abs() < 1e-2))
}

/// Returns the false claims of a cause in the readings that the decoder follows, or none if all are true in those of the reference:
/// mistakes may imitate readings.
pub fn false_claims(
    cause: &LikelyCause,
    suite: &Suite,
    run: &Run,
    decoder: &impl Fn(&Request) -> Answer,
) -> Vec<String> {
    let dialects = [run.judgment.dialect.clone(), CHOICES.reference()];
    let mut problems = dialects.into_iter().map(|dialect| {
        let reading = CHOICES.apply(&dialect, Reading::SPEC);
        let images = wrong_images(cause, suite, run, &reading, decoder);
        let mut claims = Claims {
            cause,
            images: &images,
            problems: Vec::new(),
        };
        claims.check_counts(suite, run);
        claims.check_responses(suite, run);
        if cause.misreading.is_none() && !cause.effect.starts_with("computes ") {
            claims.check_shapes();
            claims.check_places();
            claims.check_planes();
        }
        claims.check_values();
        claims.check_example();
        claims.problems
    });
    let own = problems.next().unwrap_or_default();
    match own.is_empty() || problems.next().is_some_and(|others| others.is_empty()) {
        true => Vec::new(),
        false => own,
    }
}

struct Claims<'a> {
    cause: &'a LikelyCause,
    images: &'a [WrongImage<'a>],
    problems: Vec<String>,
}

impl Claims<'_> {
    fn refute(&mut self, case: &str, fact: &str) {
        let effect = &self.cause.effect;
        self.problems.push(format!("{case} {fact}: {effect}"));
    }

    /// Requires `holds` of each image that satisfies `is_meant`, if the cause has these words.
    fn require(
        &mut self,
        words: &str,
        is_meant: impl Fn(&WrongImage<'_>) -> bool,
        holds: impl Fn(&WrongImage<'_>) -> bool,
    ) {
        if self.cause.effect.contains(words) {
            let mut meant = self.images.iter().filter(|image| is_meant(image));
            if let Some(image) = meant.find(|image| !holds(image)) {
                self.refute(&image.case.id, &format!("refutes \"{words}\""));
            }
        }
    }

    /// Returns the images in the first of their views.
    fn first_view(&self) -> Vec<&WrongImage<'_>> {
        let first = self.images.iter().map(|image| image.expected.view).min();
        let of_view = |image: &&WrongImage| Some(image.expected.view) == first;
        self.images.iter().filter(of_view).collect()
    }

    fn check_shapes(&mut self) {
        let size = |image: &WrongImage| {
            let (size, frame) = (image.expected.size, &image.received);
            (size.width, size.height) != (frame.width, frame.height)
        };
        let channels = |image: &WrongImage| image.received.channels as usize != image.channels();
        let sample_type = |image: &WrongImage| {
            image.received.samples.sample_type() != image.expected.view.sample_type()
        };
        self.require("an image of a different size", |_| true, size);
        self.require("a different number of channels", |_| true, channels);
        self.require("a different sample type", |_| true, sample_type);
    }

    fn check_places(&mut self) {
        let effect = self.cause.effect.clone();
        for rest in effect.split(", only in ").skip(1) {
            let parts: Vec<&str> = rest.split(", ").collect();
            let place = format!("in {}", parts[0]);
            for image in self
                .first_view()
                .iter()
                .filter(|image| image.has_right_shape())
            {
                let (width, height) = (image.expected.size.width, image.expected.size.height);
                let (width, height) = (width as usize, height as usize);
                let is_wrong = match is_in(&place, (0, 0), width, height) {
                    Some(_) => image
                        .wrong_samples()
                        .into_iter()
                        .any(|i| is_in(&place, image.texel(i), width, height) == Some(false)),
                    None => image.wrong_channels().into_iter().any(|channel| {
                        let names = names(image.channels(), channel);
                        !names.iter().any(|name| parts.contains(&name.as_str()))
                    }),
                };
                if is_wrong {
                    let fact = format!("has other wrong values than those {place}");
                    self.problems
                        .push(format!("{} {fact}: {effect}", image.case.id));
                    break;
                }
            }
        }
    }

    fn check_planes(&mut self) {
        let has_planes = |image: &WrongImage| {
            image.expected.view != ViewKind::Rgb
                && !image.planes.is_empty()
                && image.has_right_shape()
        };
        let is_predicted = |image: &WrongImage| {
            let mut wrong = image.wrong_channels().into_iter();
            wrong.all(|plane| image.planes[plane].reference.is_some())
        };
        self.require(
            "predicted planes, and nowhere else",
            has_planes,
            is_predicted,
        );
        self.require(
            "side information corrects, and in planes predicted from them, and nowhere else",
            has_planes,
            |image| image.are_there_or_predicted(|i| image.is_corrected(i)),
        );
        self.require(
            "planes with side information, and in planes predicted from them, and nowhere else",
            has_planes,
            |image| {
                let has_records =
                    |i: usize| !image.planes[i % image.channels()].corrected.is_empty();
                image.are_there_or_predicted(has_records)
            },
        );
        self.require(
            "wrong values in planes that are neither predicted nor corrected",
            has_planes,
            |image| image.has_wrong_plane(true),
        );
        self.require(
            "wrong values in planes that are not predicted",
            has_planes,
            |image| image.has_wrong_plane(false),
        );
        let first = self.images.iter().map(|image| image.expected.view).min();
        let values = [
            "wrong stored values",
            "wrong final values",
            "nowhere else",
            "in planes",
            "in predicted planes",
            "neither predicted nor corrected",
        ];
        let are_values = values.iter().any(|words| self.cause.effect.contains(words));
        if are_values && first == Some(ViewKind::Rgb) {
            self.refute("no image", "shows these values");
        }
        if !self
            .cause
            .effect
            .contains("neither predicted nor corrected")
        {
            self.require(
                "the correct values in the wrong places",
                |image| Some(image.expected.view) == first,
                |image| image.has_right_shape() && image.is_rearranged(),
            );
        }
    }

    fn check_values(&mut self) {
        let effect = self.cause.effect.clone();
        let Some(rest) = after(&effect, "every wrong sample") else {
            return;
        };
        let of_view = ViewKind::ALL
            .into_iter()
            .find(|view| rest.starts_with(&format!(" in view {view} ")));
        let Some(value) = after(rest, " is ").and_then(number) else {
            self.refute("the text", "has no value");
            return;
        };
        let right = after(rest, " is ").and_then(|rest| after(rest, " instead of "));
        let right = right.and_then(number);
        let images = self.images.iter();
        let images = images.filter(|image| of_view.is_none_or(|view| image.expected.view == view));
        for image in images.filter(|image| image.has_right_shape()) {
            let differs = image.wrong_samples().into_iter().any(|i| {
                let mut expected = image.expected.values[i];
                if image.expected.view == ViewKind::Rgb {
                    expected = expected.clamp(0.0, 255.0).round();
                }
                !is_printed(value, image.received.samples.real(i))
                    || right.is_some_and(|right| !is_printed(right, expected))
            });
            if differs {
                let problem = format!("{} has another wrong sample: {effect}", image.case.id);
                self.problems.push(problem);
                break;
            }
        }
    }

    /// Checks that files are said to be refused or accepted only if all of them are.
    fn check_responses(&mut self, suite: &Suite, run: &Run) {
        let effect = self.cause.effect.clone();
        // "refuses 12 and crashes on 3: every legal file …" is about several responses.
        let (outcomes, _) = effect.split_once(" legal file").unwrap_or_default();
        let is_only_refused = outcomes.starts_with("refuses ") && !outcomes.contains(" and ");
        let is_accepted = effect.starts_with("accepts malformed files");
        for id in &self.cause.explains {
            let case = suite.cases.iter().position(|case| case.id == *id);
            let observation = case.and_then(|i| run.observations[i].as_ref());
            let Some(response) = observation.map(|observation| &observation.response) else {
                continue;
            };
            let is_image = matches!(response, Response::Image { .. });
            let is_refusal = matches!(response, Response::Rejected);
            if is_only_refused && !is_refusal || is_accepted && !is_image {
                self.problems
                    .push(format!("{id} has another response: {effect}"));
                break;
            }
        }
    }

    /// Checks "12 of 160 legal files of LRGB", "(and 3 that need not be decoded)" and "(22 in view raw, 3 in view coef)".
    fn check_counts(&mut self, suite: &Suite, run: &Run) {
        let effect = self.cause.effect.clone();
        let index = |id: &String| suite.cases.iter().position(|case| case.id == *id);
        let listed: Vec<usize> = self.cause.explains.iter().filter_map(index).collect();
        let is_legal = |i: &usize| suite.cases[*i].expect == Expect::Decode;
        if let Some((before, rest)) = effect.split_once(" legal files of ")
            && !effect.contains("(the others also fail)")
        {
            let mut words = before.rsplit(' ');
            let [all, _, count] = [(); 3].map(|()| words.next().unwrap_or_default());
            let words = rest.split([',', ' ']).filter(|word| !word.is_empty());
            let formats: Vec<Format> = words.map_while(|word| word.parse().ok()).collect();
            let is_of = |i: &usize| formats.contains(&suite.cases[*i].format());
            let asked = |i: &usize| run.observations[*i].is_some();
            let legal = (0..suite.cases.len()).filter(|i| is_legal(i) && is_of(i) && asked(i));
            let mine = listed.iter().filter(|i| is_legal(i));
            let counts = [mine.clone().count(), legal.count()].map(|count| count.to_string());
            if counts != [count, all] {
                self.refute(&counts.join(" of "), "is the count");
            }
            if mine.clone().any(|i| !is_of(i)) {
                self.refute("a legal file", "has another format");
            }
        }
        for view in ViewKind::ALL {
            let mut right = 0;
            for &i in &listed {
                let observation = run.observations[i].as_ref();
                right += usize::from(observation.is_some_and(|one| one.view.kind() == view));
            }
            let words = format!(" in view {view}");
            for (at, _) in effect.match_indices(&words) {
                let count = effect[..at].rsplit([' ', '(']).next().unwrap_or_default();
                let is_wrong = count.parse::<usize>().is_ok_and(|count| count != right);
                if is_wrong {
                    self.refute(&right.to_string(), &format!("is the number{words}"));
                }
            }
        }
    }

    /// Checks the values of the example.
    fn check_example(&mut self) {
        let example = self.cause.example.clone().unwrap_or_default();
        let Some(rest) = after(&example, ", texel (") else {
            return;
        };
        let parsed = (|| {
            let (place, rest) = rest.split_once("), ")?;
            let (x, y) = place.split_once(", ")?;
            let (channel, rest) = rest.split_once(": received ")?;
            let (received, rest) = rest.split_once(", expected ")?;
            let (x, y): (usize, usize) = (x.parse().ok()?, y.parse().ok()?);
            Some((x, y, channel, number(received)?, number(rest)?, rest))
        })();
        let Some((x, y, channel, received, expected, rest)) = parsed else {
            self.refute(&example, "cannot be parsed");
            return;
        };
        let id = &self.cause.explains[0];
        let image = self.images.iter().find(|image| image.case.id == *id);
        let Some(image) = image.filter(|image| image.has_right_shape()) else {
            self.refute(id, "has no image of the expected shape");
            return;
        };
        let width = image.expected.size.width as usize;
        let all = 0..image.channels();
        let Some(c) = all
            .clone()
            .find(|&c| channel_name(image.channels(), c) == channel)
        else {
            self.refute(&example, "has no such channel");
            return;
        };
        let i = (y * width + x) * image.channels() + c;
        let right = image.expected.values[i];
        if !example.contains(&format!(" {id}, ")) {
            self.refute(&example, "is not the first case");
        }
        if !is_printed(received, image.received.samples.real(i)) {
            self.refute(&example, "has another received value");
        }
        // A value in another reading is followed by the name of its ruling.
        let is_other_reading = rest.contains(" with ");
        if !is_other_reading && !is_printed(expected, right) {
            self.refute(&example, &format!("has the expected value {right}"));
        }
        if !is_other_reading && image.expected.is_near(i, image.received.samples.real(i)) {
            self.refute(&example, "is not wrong");
        }
    }
}
