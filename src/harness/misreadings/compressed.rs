//! §2.9.1–2.9.7: the parameter, the lists, and what is predicted from what

#![allow(
    clippy::cast_possible_wrap,
    reason = "planes are 18 at most, and texels fewer than a limit allows"
)]

use std::borrow::Cow;

use super::{At, Decision, Misreading};
use crate::decode::compressed::{self, Extent, Number, Plan, RawLists, Step};
use crate::decode::planes::Coded;
use crate::decode::{Ptm, predict as rule};
use crate::error::{Error, Kind, Result};
use crate::ptm::Size;
use crate::reading::Reading;

pub(super) const ALL: &[Misreading] = &[
    // 2.9 and 2.9.1
    Misreading {
        slug: "motion-on-one-line-only",
        clause: "2.9/2",
        effect: "refuses motion vectors on two lines",
        mend: "x and y stand on a line each; the one real file has it so",
        at: At::Bytes(|file| {
            let vectors = file.texts(&["2.9.3/1"]).len();
            file.refused_if(vectors > 1 && file.after("2.9.3/1", vectors / 2 - 1).contains(&b'\n'))
        }),
    },
    Misreading {
        slug: "missing-records-forgiven",
        clause: "2.9.8/2",
        effect: "takes side information that the file has not for none",
        mend: "refuse a file that is too short",
        at: At::Bytes(|file| match crate::decode::fields(file.file).1 {
            Some(error) if error.clause() == "2.9.8/2" => file.respelled(|clause, text| {
                (clause == "2.9.7/1" && text != "0").then(|| "0".to_owned())
            }),
            _ => file.unchanged(),
        }),
    },
    Misreading {
        slug: "compressed-size-sign-ignored",
        clause: "2.9.6/2",
        effect: "ignores the sign of a compressed size",
        mend: "refuse negative sizes",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                text.strip_prefix('-')
                    .filter(|_| clause == "2.9.6/1")
                    .map(str::to_owned)
            })
        }),
    },
    Misreading {
        slug: "side-information-always",
        clause: "2.9.7/2",
        effect: "reads a record even where the side information has no bytes",
        mend: "a size of 0 is no side information",
        at: At::Bytes(|file| {
            file.respelled(|clause, text| {
                (clause == "2.9.7/1" && text == "0").then(|| "5".to_owned())
            })
        }),
    },
    Misreading {
        slug: "parameter-not-read",
        clause: "2.9.1/1",
        effect: "does not read the compression parameter and takes every number for the one before it",
        mend: "one number stands before the transforms",
        at: At::Bytes(|file| file.refused_if(!file.texts(&["2.9.1/1"]).is_empty())),
    },
    Misreading {
        slug: "parameter-always-a-quality",
        clause: "2.9.1/2",
        effect: "refuses parameters below 20, those of JPEG-LS too",
        mend: "for JPEG-LS the parameter is the largest loss, and 0 is lossless",
        at: At::Bytes(|file| {
            let below = |text: &&str| text.parse().is_ok_and(|value: i64| value < 20);
            file.refused_if(file.texts(&["2.9.1/1"]).first().is_some_and(below))
        }),
    },
    Misreading {
        slug: "jpeg-ls-lossless-only",
        clause: "2.9.1/2",
        effect: "refuses lossy JPEG-LS",
        mend: "a parameter above 0 is the largest loss of a texel",
        at: At::Bytes(|file| {
            let lossy = file
                .texts(&["2.9.1/1"])
                .first()
                .is_some_and(|text| *text != "0");
            let jpeg_ls = file
                .texts(&["2.2/1"])
                .first()
                .is_some_and(|text| text.contains("JPEGLS"));
            file.refused_if(lossy && jpeg_ls)
        }),
    },
    Misreading {
        slug: "compressed-lists-of-nine",
        clause: "2.9/3",
        effect: "reads lists of nine numbers for 18 planes too",
        mend: "a list has a number for each plane: 18 for RGB, 9 for LRGB",
        at: At::Bytes(|file| {
            let rgb = file
                .texts(&["2.2/1"])
                .first()
                .is_some_and(|text| text.starts_with("PTM_FORMAT_JPEG") && text.ends_with("_RGB"));
            file.refused_if(rgb)
        }),
    },
    Misreading {
        slug: "negative-vectors-refused",
        clause: "2.9.3/2",
        effect: "refuses negative motion vectors",
        mend: "motion vectors have a sign",
        at: At::Bytes(|file| {
            file.refused_if(
                file.texts(&["2.9.3/1"])
                    .iter()
                    .any(|text| text.starts_with('-')),
            )
        }),
    },
    // 2.9.2: which transform
    plan(
        "any-transform-refused",
        "2.9.2/1",
        "refuses every file with a transform",
        "HP's own files invert planes",
        |r| Reading {
            plan: |lists| match lists
                .transforms
                .iter()
                .find(|transform| transform.value != 0)
            {
                Some(transform) => Err(refused(transform)),
                None => compressed::plan(lists),
            },
            ..r
        },
    ),
    plan(
        "motion-refused",
        "2.9.2/4",
        "refuses motion compensation as malformed",
        "answer 69 if you do not do it",
        |r| Reading {
            plan: |lists| match lists
                .transforms
                .iter()
                .find(|transform| transform.value & 2 != 0)
            {
                Some(transform) => Err(refused(transform)),
                None => compressed::plan(lists),
            },
            ..r
        },
    ),
    plan(
        "undefined-transforms-ignored",
        "2.9.2/5",
        "uses the two bits it knows of a transform and ignores the others",
        "refuse transforms that are not defined",
        |r| Reading {
            plan: |lists| {
                let mut lists = lists.clone();
                for transform in &mut lists.transforms {
                    transform.value &= 3;
                }
                compressed::plan(&lists)
            },
            ..r
        },
    ),
    steps(
        "transform-by-equality",
        "2.9.2/2",
        "takes transform 3 for none",
        "transforms are bits: 3 is 1 and 2",
        |r| Reading {
            plan: |lists| {
                changed(lists, |lists, i, step| {
                    let both = lists.transforms[i].value == 3;
                    Step {
                        inverted: step.inverted && !both,
                        moved: step.moved && !both,
                        ..step
                    }
                })
            },
            ..r
        },
    ),
    steps(
        "transform-three-is-inversion",
        "2.9.2/2",
        "takes transform 3 for inversion alone",
        "transforms are bits: 3 is 1 and 2",
        |r| Reading {
            plan: |lists| {
                changed(lists, |lists, i, step| Step {
                    moved: step.moved && lists.transforms[i].value != 3,
                    ..step
                })
            },
            ..r
        },
    ),
    steps(
        "transform-three-is-motion",
        "2.9.2/2",
        "takes transform 3 for motion alone",
        "transforms are bits: 3 is 1 and 2",
        |r| Reading {
            plan: |lists| {
                changed(lists, |lists, i, step| Step {
                    inverted: step.inverted && lists.transforms[i].value != 3,
                    ..step
                })
            },
            ..r
        },
    ),
    steps(
        "any-transform-inverts",
        "2.9.2/2",
        "inverts the reference whatever the transform",
        "transforms are bits: 1 inverts, 2 displaces",
        |r| Reading {
            plan: |lists| {
                changed(lists, |_, _, step| Step {
                    inverted: step.inverted || step.moved,
                    ..step
                })
            },
            ..r
        },
    ),
    steps(
        "any-transform-moves",
        "2.9.2/4",
        "displaces the reference whatever the transform",
        "only transforms with bit 2 displace",
        |r| Reading {
            plan: |lists| {
                changed(lists, |_, _, step| Step {
                    moved: step.inverted || step.moved,
                    ..step
                })
            },
            ..r
        },
    ),
    steps(
        "transform-bits-exchanged",
        "2.9.2/2",
        "takes 1 for motion and 2 for inversion",
        "1 inverts, 2 displaces",
        |r| Reading {
            plan: |lists| {
                changed(lists, |_, _, step| Step {
                    inverted: step.moved,
                    moved: step.inverted,
                    ..step
                })
            },
            ..r
        },
    ),
    steps(
        "inversion-ignored",
        "2.9.2/3",
        "does not invert references",
        "1 inverts the reference before prediction",
        |r| Reading {
            plan: |lists| {
                changed(lists, |_, _, step| Step {
                    inverted: false,
                    ..step
                })
            },
            ..r
        },
    ),
    steps(
        "motion-ignored",
        "2.9.2/4",
        "does not displace references",
        "2 displaces the reference before prediction",
        |r| Reading {
            plan: |lists| {
                changed(lists, |_, _, step| Step {
                    moved: false,
                    ..step
                })
            },
            ..r
        },
    ),
    steps(
        "vectors-without-their-bit",
        "2.9.2/4",
        "displaces the reference wherever there is a vector",
        "only transforms with bit 2 displace",
        |r| Reading {
            plan: |lists| {
                changed(lists, |_, _, step| Step {
                    moved: true,
                    ..step
                })
            },
            ..r
        },
    ),
    steps(
        "transforms-one-plane-late",
        "2.9.2/1",
        "uses the transform of the plane before",
        "the transforms stand in plane order",
        |r| Reading {
            plan: |lists| {
                changed(lists, |lists, i, step| {
                    let transform = lists.transforms[i.saturating_sub(1)].value;
                    Step {
                        inverted: transform & 1 != 0,
                        moved: transform & 2 != 0,
                        ..step
                    }
                })
            },
            ..r
        },
    ),
    steps(
        "transform-of-the-reference",
        "2.9.2/1",
        "uses the transform that stands at the reference",
        "it stands at the predicted plane",
        |r| Reading {
            plan: |lists| {
                changed(lists, |lists, _, step| {
                    let transform = step
                        .reference
                        .map_or(0, |reference| lists.transforms[reference].value);
                    Step {
                        inverted: transform & 1 != 0,
                        moved: transform & 2 != 0,
                        ..step
                    }
                })
            },
            ..r
        },
    ),
    // 2.9.2: what it does
    invert(
        "inversion-from-256",
        "takes 256 − v for the inverse",
        |r| Reading {
            invert: |plane| each(plane, |value| 0u8.wrapping_sub(value)),
            ..r
        },
    ),
    invert(
        "inversion-around-128",
        "mirrors values at 128 and keeps 0",
        |r| Reading {
            invert: |plane| {
                each(plane, |value| {
                    if value == 0 {
                        255
                    } else {
                        0u8.wrapping_sub(value)
                    }
                });
            },
            ..r
        },
    ),
    invert(
        "inversion-from-254",
        "takes 254 − v for the inverse",
        |r| Reading {
            invert: |plane| each(plane, |value| 254u8.wrapping_sub(value)),
            ..r
        },
    ),
    invert(
        "inversion-of-the-high-bit",
        "turns the highest bit only",
        |r| Reading {
            invert: |plane| each(plane, |value| value ^ 0x80),
            ..r
        },
    ),
    invert(
        "inversion-turns-the-plane-round",
        "takes inversion for the reverse order of texels",
        |r| Reading {
            invert: <[u8]>::reverse,
            ..r
        },
    ),
    reconstruct(
        "inversion-with-one-carry",
        "2.9.2/3",
        "computes −1 − v for the inverse and adds 256 once",
        "the inverse is 255 − v, the sum is taken modulo 256",
        |r| Reading {
            reconstruct: |coded, reading| {
                planes(coded, reading, |i, plane, done, _| {
                    let step = &coded.plan.steps[i];
                    match step.reference {
                        Some(reference) if step.inverted && !step.moved => {
                            each_pair(plane, &done[reference], |value, reference| {
                                let sum = i16::from(value) - i16::from(reference) - 129;
                                clamped(if sum < 0 { sum + 256 } else { sum })
                            });
                        }
                        _ => coded.predict(i, plane, done, reading),
                    }
                })
            },
            ..r
        },
    ),
    reconstruct(
        "inversion-of-the-residual",
        "2.9.2/1",
        "inverts the residuals instead of the reference",
        "a transform acts on the reference",
        |r| Reading {
            reconstruct: |coded, reading| {
                planes(coded, reading, |i, plane, done, steps| {
                    if steps[i].reference.is_some() && steps[i].inverted {
                        (reading.invert)(plane);
                    }
                    predict(
                        coded,
                        reading,
                        plane,
                        done,
                        Step {
                            inverted: false,
                            ..steps[i]
                        },
                    );
                })
            },
            ..r
        },
    ),
    reconstruct(
        "inversion-of-the-result",
        "2.9.2/1",
        "inverts the plane after prediction",
        "a transform acts on the reference, before prediction",
        |r| Reading {
            reconstruct: |coded, reading| {
                planes(coded, reading, |i, plane, done, steps| {
                    predict(
                        coded,
                        reading,
                        plane,
                        done,
                        Step {
                            inverted: false,
                            ..steps[i]
                        },
                    );
                    if steps[i].reference.is_some() && steps[i].inverted {
                        (reading.invert)(plane);
                    }
                })
            },
            ..r
        },
    ),
    reconstruct(
        "motion-of-the-residual",
        "2.9.2/1",
        "displaces the residuals instead of the reference",
        "a transform acts on the reference",
        |r| Reading {
            reconstruct: |coded, reading| {
                planes(coded, reading, |i, plane, done, steps| {
                    if steps[i].reference.is_some() && steps[i].moved {
                        let moved = rule::displace(plane, steps[i].motion, coded.size, reading);
                        plane.copy_from_slice(&moved);
                    }
                    predict(
                        coded,
                        reading,
                        plane,
                        done,
                        Step {
                            moved: false,
                            ..steps[i]
                        },
                    );
                })
            },
            ..r
        },
    ),
    reconstruct(
        "motion-of-the-result",
        "2.9.2/1",
        "displaces the plane after prediction",
        "a transform acts on the reference, before prediction",
        |r| Reading {
            reconstruct: |coded, reading| {
                planes(coded, reading, |i, plane, done, steps| {
                    predict(
                        coded,
                        reading,
                        plane,
                        done,
                        Step {
                            moved: false,
                            ..steps[i]
                        },
                    );
                    if steps[i].reference.is_some() && steps[i].moved {
                        let moved = rule::displace(plane, steps[i].motion, coded.size, reading);
                        plane.copy_from_slice(&moved);
                    }
                })
            },
            ..r
        },
    ),
    reconstruct(
        "transforms-of-intra-planes",
        "2.9.5/2",
        "inverts intra coded planes whose transform says so",
        "an intra coded plane has no reference to transform",
        |r| Reading {
            reconstruct: |coded, reading| {
                planes(coded, reading, |i, plane, done, steps| {
                    coded.predict(i, plane, done, reading);
                    if steps[i].reference.is_none() && steps[i].inverted {
                        (reading.invert)(plane);
                    }
                })
            },
            ..r
        },
    ),
    reconstruct(
        "reference-stays-inverted",
        "2.9.2/1",
        "inverts the reference itself and leaves it so",
        "invert a copy: the reference is a plane of its own",
        |r| Reading {
            reconstruct: |coded, reading| {
                let mut done = coded.blank_planes();
                for &i in &coded.plan.sequence {
                    let mut plane = coded.residuals(i, reading)?;
                    let step = coded.plan.steps[i];
                    if let (Some(reference), true) = (step.reference, step.inverted) {
                        (reading.invert)(&mut done[reference]);
                    }
                    predict(
                        coded,
                        reading,
                        &mut plane,
                        &done,
                        Step {
                            inverted: false,
                            ..step
                        },
                    );
                    coded.mend(i, &mut plane, reading)?;
                    done[i] = plane;
                }
                Ok(done)
            },
            ..r
        },
    ),
    reconstruct(
        "motion-leaves-planes-empty",
        "2.9.2/4",
        "leaves planes with motion compensation empty",
        "refuse the file with 69 if you do not do it",
        |r| Reading {
            reconstruct: |coded, reading| {
                planes(coded, reading, |i, plane, done, steps| {
                    coded.predict(i, plane, done, reading);
                    if steps[i].reference.is_some() && steps[i].moved {
                        plane.fill(0);
                    }
                })
            },
            ..r
        },
    ),
    // 2.9.3
    vectors(
        "vectors-interleaved",
        "2.9.3/1",
        "reads the vectors as pairs of x and y",
        "first x of all planes, then y of all planes",
        |r| Reading {
            plan: |lists| {
                displacing(lists, |motion, i, _| {
                    (motion[2 * i].value, motion[2 * i + 1].value)
                })
            },
            ..r
        },
    ),
    vectors(
        "vectors-y-first",
        "2.9.3/1",
        "takes the first half of the vectors for y",
        "first x of all planes, then y of all planes",
        |r| Reading {
            plan: |lists| displacing(lists, |_, _, (x, y)| (y, x)),
            ..r
        },
    ),
    vectors(
        "vectors-one-plane-late",
        "2.9.3/1",
        "uses the vector of the plane before",
        "the vectors stand in plane order",
        |r| Reading {
            plan: |lists| {
                displacing(lists, |motion, i, _| {
                    let before = i.saturating_sub(1);
                    (
                        motion[before].value,
                        motion[motion.len() / 2 + before].value,
                    )
                })
            },
            ..r
        },
    ),
    vectors(
        "motion-x-only",
        "2.9.3/1",
        "displaces along x only",
        "the second half of the vectors is y",
        |r| Reading {
            plan: |lists| displacing(lists, |_, _, (x, _)| (x, 0)),
            ..r
        },
    ),
    vectors(
        "motion-y-only",
        "2.9.3/1",
        "displaces along y only",
        "the first half of the vectors is x",
        |r| Reading {
            plan: |lists| displacing(lists, |_, _, (_, y)| (0, y)),
            ..r
        },
    ),
    vectors(
        "motion-whole-texels",
        "2.9.3/2",
        "takes vectors for whole texels",
        "divide them by 2",
        |r| Reading {
            plan: |lists| displacing(lists, |_, _, (x, y)| (2 * x, 2 * y)),
            ..r
        },
    ),
    vectors(
        "motion-quarter-texels",
        "2.9.3/2",
        "takes vectors for quarters of a texel",
        "divide them by 2, once",
        |r| Reading {
            plan: |lists| displacing(lists, |_, _, (x, y)| (x / 2, y / 2)),
            ..r
        },
    ),
    vectors(
        "motion-halves-cut",
        "2.9.3/2",
        "divides vectors as integers and loses their halves",
        "half displacements are means of samples",
        |r| Reading {
            plan: |lists| displacing(lists, |_, _, (x, y)| (x / 2 * 2, y / 2 * 2)),
            ..r
        },
    ),
    vectors(
        "motion-halves-floored",
        "2.9.3/2",
        "shifts vectors to the right and loses their halves",
        "half displacements are means of samples",
        |r| Reading {
            plan: |lists| displacing(lists, |_, _, (x, y)| (x >> 1 << 1, y >> 1 << 1)),
            ..r
        },
    ),
    vectors(
        "motion-halves-away",
        "2.9.3/2",
        "rounds half displacements away from zero",
        "half displacements are means of samples",
        |r| Reading {
            plan: |lists| displacing(lists, |_, _, (x, y)| (x + x % 2, y + y % 2)),
            ..r
        },
    ),
    vectors(
        "motion-sign-lost",
        "2.9.3/2",
        "ignores the sign of vectors",
        "motion vectors have a sign",
        |r| Reading {
            plan: |lists| displacing(lists, |_, _, (x, y)| (x.abs(), y.abs())),
            ..r
        },
    ),
    vectors(
        "vectors-in-a-byte",
        "2.9.3/2",
        "keeps vectors in unsigned bytes",
        "motion vectors have a sign",
        |r| Reading {
            plan: |lists| {
                displacing(lists, |_, _, (x, y)| {
                    (i64::from(x as u8), i64::from(y as u8))
                })
            },
            ..r
        },
    ),
    vectors(
        "vectors-in-a-signed-byte",
        "2.9.3/2",
        "keeps vectors in signed bytes",
        "a vector is a number of any size",
        |r| Reading {
            plan: |lists| {
                displacing(lists, |_, _, (x, y)| {
                    (i64::from(x as i8), i64::from(y as i8))
                })
            },
            ..r
        },
    ),
    vectors(
        "vectors-in-16-bits",
        "2.9.3/2",
        "keeps vectors in 16 bits",
        "a vector is a number of any size",
        |r| Reading {
            plan: |lists| {
                displacing(lists, |_, _, (x, y)| {
                    (i64::from(x as i16), i64::from(y as i16))
                })
            },
            ..r
        },
    ),
    vectors(
        "motion-along-both-only",
        "2.9.2/4",
        "displaces only where neither number of the vector is 0",
        "a displacement along one axis is one too",
        |r| Reading {
            plan: |lists| {
                displacing(
                    lists,
                    |_, _, (x, y)| if x == 0 || y == 0 { (0, 0) } else { (x, y) },
                )
            },
            ..r
        },
    ),
    vectors(
        "half-vectors-one-way",
        "2.9.3/5",
        "displaces by a half along x only where both displacements are halves",
        "four samples make one",
        |r| Reading {
            plan: |lists| {
                displacing(
                    lists,
                    |_, _, (x, y)| {
                        if x & y & 1 != 0 { (x, y - 1) } else { (x, y) }
                    },
                )
            },
            ..r
        },
    ),
    Misreading {
        slug: "vector-of-the-reference",
        clause: "2.9.3/1",
        effect: "uses the vector that stands at the reference",
        mend: "it stands at the predicted plane",
        at: At::Reading(Decision::Plan, |r| Reading {
            plan: |lists| {
                changed(lists, |lists, _, step| match step.reference {
                    Some(j) => Step {
                        motion: (
                            lists.motion[j].value,
                            lists.motion[lists.motion.len() / 2 + j].value,
                        ),
                        ..step
                    },
                    None => step,
                })
            },
            ..r
        }),
    },
    Misreading {
        slug: "motion-rounded-twice",
        clause: "2.9.3/5",
        effect: "rounds the mean of four samples along x and then along y",
        mend: "add up all four before rounding",
        at: At::Reading(Decision::MotionHalf, |r| Reading {
            motion_half: |[a, b, c, d]| {
                let mean = |a: u8, b: u8| u8::midpoint(a, b) + ((a ^ b) & 1);
                mean(mean(a, b), mean(c, d))
            },
            ..r
        }),
    },
    predictor(
        "motion-runs-over-row-ends",
        "2.9.3/6",
        "takes the next row for what is right of a row",
        "x stays within its row",
        |r| Reading {
            predictor: |reference, step, size, reading| {
                displaced(reference, step, size, reading, |plane, x, y, width, _| {
                    let at = y
                        .saturating_mul(width)
                        .saturating_add(x)
                        .clamp(0, plane.len() as i64 - 1);
                    plane[at as usize]
                })
            },
            ..r
        },
    ),
    predictor(
        "motion-halves-toward-zero",
        "2.9.3/2",
        "halves negative vectors towards zero, and takes −1/2 for 1/2",
        "−1/2 lies between −1 and 0: shift to the right instead of dividing",
        |r| Reading {
            predictor: |reference, step, size, reading| {
                tapped(reference, step, size, reading, |at, [d, _], _| {
                    let first = at + d / 2;
                    [first, first + (d & 1)]
                })
            },
            ..r
        },
    ),
    predictor(
        "motion-half-of-the-other-axis",
        "2.9.3/2",
        "takes the half of x for that of y",
        "x and y are displaced by themselves",
        |r| Reading {
            predictor: |reference, step, size, reading| {
                tapped(reference, step, size, reading, |at, [d, other], axis| {
                    let first = at + (d >> 1);
                    let half = if axis.is_x { d } else { other };
                    [first, first + (half & 1)]
                })
            },
            ..r
        },
    ),
    predictor(
        "motion-half-of-the-edge",
        "2.9.3/6",
        "keeps the first sample of a mean inside the plane and takes the next one for the second",
        "each sample of a mean stays inside by itself",
        |r| Reading {
            predictor: |reference, step, size, reading| {
                tapped(reference, step, size, reading, |at, [d, _], axis| {
                    let first = (at + (d >> 1)).clamp(0, axis.length - 1);
                    [first, first + (d & 1)]
                })
            },
            ..r
        },
    ),
    predictor(
        "motion-half-runs-over-row-ends",
        "2.9.3/6",
        "takes the first sample of the next row for the second one of a mean at the end of a row",
        "each sample of a mean stays inside by itself",
        |r| Reading {
            predictor: |reference, step, size, reading| {
                displaced(
                    reference,
                    step,
                    size,
                    reading,
                    |plane, x, y, width, height| {
                        // One column beyond the last lies where the next row begins.
                        let x = if x == width { x } else { x.clamp(0, width - 1) };
                        let at = y.clamp(0, height - 1) * width + x;
                        plane[(at as usize).min(plane.len() - 1)]
                    },
                )
            },
            ..r
        },
    ),
    predictor(
        "motion-half-begins-again",
        "2.9.3/6",
        "takes the first row or column for the second sample of a mean at the last one",
        "see ruling motion-border",
        |r| Reading {
            predictor: |reference, step, size, reading| {
                tapped(reference, step, size, reading, |at, [d, _], axis| {
                    let first = (at + (d >> 1)).clamp(0, axis.length - 1);
                    let second = at + (d >> 1) + (d & 1);
                    let inside = (0..axis.length).contains(&second);
                    [first, if inside || second < 0 { second } else { 0 }]
                })
            },
            ..r
        },
    ),
    predictor(
        "motion-x-within-the-height",
        "2.9.3/6",
        "keeps x inside the height of the map",
        "x stays inside the width, y inside the height",
        |r| Reading {
            predictor: |reference, step, size, reading| {
                tapped(reference, step, size, reading, |at, [d, _], axis| {
                    let first = at + (d >> 1);
                    let most = if axis.is_x {
                        axis.other.min(axis.length)
                    } else {
                        axis.length
                    };
                    [first, first + (d & 1)].map(|at| at.clamp(0, most - 1))
                })
            },
            ..r
        },
    ),
    predictor(
        "motion-border-black",
        "2.9.3/6",
        "takes 0 for what is outside a plane",
        "see ruling motion-border",
        |r| Reading {
            predictor: |reference, step, size, reading| {
                displaced(
                    reference,
                    step,
                    size,
                    reading,
                    |plane, x, y, width, height| {
                        let inside = (0..width).contains(&x) && (0..height).contains(&y);
                        if inside {
                            plane[(y * width + x) as usize]
                        } else {
                            0
                        }
                    },
                )
            },
            ..r
        },
    ),
    // 2.9.4
    plan(
        "order-as-strict-sequence",
        "2.9.4/1",
        "takes the order list for the planes in the order in which to decode them, and refuses a file whose references then come late",
        "number i is the rank of plane i",
        |r| Reading {
            plan: |lists| {
                let mut plan = compressed::plan(lists)?;
                plan.sequence = listed(lists)?;
                let mut done = vec![false; plan.steps.len()];
                for &i in &plan.sequence {
                    if plan.steps[i]
                        .reference
                        .is_some_and(|reference| !done[reference])
                    {
                        return Err(refused(&lists.order[i]));
                    }
                    done[i] = true;
                }
                Ok(plan)
            },
            ..r
        },
    ),
    plan(
        "order-as-sequence",
        "2.9.4/1",
        "takes the order list for the planes in the order in which to decode them",
        "number i is the rank of plane i",
        |r| Reading {
            plan: |lists| {
                Ok(Plan {
                    sequence: listed(lists)?,
                    ..unranked(lists)?
                })
            },
            ..r
        },
    ),
    plan(
        "order-ignored",
        "2.9.4/2",
        "decodes planes in plane order",
        "the plane of the lowest rank comes first",
        |r| Reading {
            plan: unranked,
            ..r
        },
    ),
    plan(
        "order-reversed",
        "2.9.4/2",
        "decodes the plane of the highest rank first",
        "the plane of the lowest rank comes first",
        |r| Reading {
            plan: |lists| {
                let mut plan = compressed::plan(lists)?;
                plan.sequence.reverse();
                Ok(plan)
            },
            ..r
        },
    ),
    plan(
        "order-one-based",
        "2.9.4/1",
        "counts ranks from one and never decodes a plane of rank 0",
        "ranks begin at 0",
        |r| Reading {
            plan: |lists| {
                let mut plan = compressed::plan(lists)?;
                plan.sequence.retain(|&i| lists.order[i].value > 0);
                Ok(plan)
            },
            ..r
        },
    ),
    plan(
        "one-plane-a-rank",
        "2.9.4/3",
        "looks for one plane of each rank and never decodes the others",
        "decode every plane, whatever its rank",
        |r| Reading {
            plan: |lists| {
                let mut plan = compressed::plan(lists)?;
                let planes = lists.order.len() as i64;
                plan.sequence = (0..planes)
                    .filter_map(|rank| lists.order.iter().position(|number| number.value == rank))
                    .collect();
                Ok(plan)
            },
            ..r
        },
    ),
    plan(
        "ranks-of-references-unchecked",
        "2.9.4/2",
        "predicts planes from references that are not decoded yet",
        "refuse a reference of equal or higher rank",
        |r| Reading {
            plan: |lists| {
                let mut plan = unranked(lists)?;
                plan.sequence.sort_by_key(|&plane| lists.order[plane].value);
                Ok(plan)
            },
            ..r
        },
    ),
    // 2.9.5
    plan(
        "reference-one-based",
        "2.9.5/1",
        "counts references from one",
        "the first plane is plane 0",
        |r| Reading {
            plan: |lists| referring(lists, |_, value| value.saturating_sub(1)),
            ..r
        },
    ),
    plan(
        "reference-one-late",
        "2.9.5/1",
        "takes the plane behind the reference",
        "the first plane is plane 0",
        |r| Reading {
            plan: |lists| {
                let planes = lists.references.len() as i64;
                referring_to(lists, |_, value| {
                    if value < 0 {
                        value
                    } else {
                        value.saturating_add(1).min(planes - 1)
                    }
                })
            },
            ..r
        },
    ),
    plan(
        "reference-is-a-rank",
        "2.9.5/1",
        "takes references for ranks",
        "a reference is the index of a plane",
        |r| Reading {
            plan: |lists| {
                let by_rank = |_: usize, rank: i64| {
                    if rank < 0 {
                        -1
                    } else {
                        lists
                            .order
                            .iter()
                            .position(|number| number.value == rank)
                            .map_or(-1, |i| i as i64)
                    }
                };
                referring_to(lists, by_rank)
            },
            ..r
        },
    ),
    plan(
        "reference-is-the-plane-before",
        "2.9.5/1",
        "predicts from the plane decoded just before",
        "predict from the plane whose index stands in the list",
        |r| Reading {
            plan: |lists| {
                let mut plan = compressed::plan(lists)?;
                for pair in plan.sequence.windows(2) {
                    if let &[before, i] = pair
                        && plan.steps[i].reference.is_some()
                    {
                        plan.steps[i].reference = Some(before);
                    }
                }
                Ok(plan)
            },
            ..r
        },
    ),
    plan(
        "reference-zero-is-intra",
        "2.9.5/2",
        "takes reference 0 for intra coded",
        "only -1 means intra coded; 0 is the first plane",
        |r| Reading {
            plan: |lists| referring(lists, |_, value| if value == 0 { -1 } else { value }),
            ..r
        },
    ),
    plan(
        "references-ignored",
        "2.9.5/1",
        "takes every plane for intra coded",
        "add what is predicted from the reference",
        |r| Reading {
            plan: |lists| referring(lists, |_, _| -1),
            ..r
        },
    ),
    plan(
        "reference-past-the-last-is-intra",
        "2.9.5/3",
        "takes references to planes that do not exist for intra coded",
        "refuse them",
        |r| Reading {
            plan: |lists| {
                let planes = lists.references.len() as i64;
                referring(lists, |_, value| if value < planes { value } else { -1 })
            },
            ..r
        },
    ),
    reconstruct(
        "intra-planes-less-128",
        "2.9.5/2",
        "takes 128 off intra coded planes too",
        "an intra coded plane is what its stream holds",
        |r| Reading {
            reconstruct: |coded, reading| {
                planes(coded, reading, |i, plane, done, steps| {
                    coded.predict(i, plane, done, reading);
                    if steps[i].reference.is_none() {
                        each(plane, |value| value.wrapping_sub(128));
                    }
                })
            },
            ..r
        },
    ),
    reconstruct(
        "predicted-from-residuals",
        "2.9.5/1",
        "predicts from what the reference's stream holds",
        "predict from the finished reference",
        |r| Reading {
            reconstruct: |coded, reading| {
                let streams = (0..coded.plan.steps.len())
                    .map(|i| coded.residuals(i, reading))
                    .collect::<Result<Vec<_>>>()?;
                planes(coded, reading, |i, plane, _, _| {
                    coded.predict(i, plane, &streams, reading);
                })
            },
            ..r
        },
    ),
    predict_as("no-128", "adds the residual as it is", |r| Reading {
        predict: |_, residuals, predictor| each_pair(residuals, predictor, u8::wrapping_add),
        ..r
    }),
    predict_as("offset-127", "takes 127 off the residual", |r| Reading {
        predict: |_, residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                value.wrapping_add(predicted).wrapping_sub(127)
            });
        },
        ..r
    }),
    predict_as("wrap-mod-255", "takes the sum modulo 255", |r| Reading {
        predict: |_, residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                (sum(value, predicted) % 255) as u8
            });
        },
        ..r
    }),
    predict_as(
        "wrap-below-only",
        "wraps sums below 0 and cuts sums off at 255",
        |r| Reading {
            predict: |_, residuals, predictor| {
                each_pair(residuals, predictor, |value, predicted| {
                    match sum(value, predicted) {
                        sum @ ..0 => sum as u8,
                        sum => clamped(sum),
                    }
                });
            },
            ..r
        },
    ),
    predict_as(
        "wrap-above-only",
        "wraps sums above 255 and sets negative sums to 0",
        |r| Reading {
            predict: |_, residuals, predictor| {
                each_pair(residuals, predictor, |value, predicted| {
                    match sum(value, predicted) {
                        sum @ 0.. => sum as u8,
                        _ => 0,
                    }
                });
            },
            ..r
        },
    ),
    predict_as("clamp-not-wrap", "clamps sums to 0…255", |r| Reading {
        predict: |_, residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                clamped(sum(value, predicted))
            });
        },
        ..r
    }),
    predict_as("residual-subtracted", "subtracts the residual", |r| {
        Reading {
            predict: |_, residuals, predictor| {
                each_pair(residuals, predictor, |value, predicted| {
                    predicted.wrapping_sub(value).wrapping_add(128)
                });
            },
            ..r
        }
    }),
    predict_as("residual-doubled", "adds the residual twice", |r| Reading {
        predict: |_, residuals, predictor| {
            each_pair(residuals, predictor, |value, predicted| {
                predicted.wrapping_add(value.wrapping_sub(128).wrapping_mul(2))
            });
        },
        ..r
    }),
    predict_as(
        "residual-zero-is-256",
        "takes a residual of 0 for 256 and does not wrap the sum",
        |r| Reading {
            predict: |_, residuals, predictor| {
                each_pair(residuals, predictor, |value, predicted| {
                    if value == 0 {
                        predicted.saturating_add(128)
                    } else {
                        value.wrapping_add(predicted).wrapping_sub(128)
                    }
                });
            },
            ..r
        },
    ),
    predict_as(
        "prediction-is-a-mean",
        "takes the mean of residual and reference",
        |r| Reading {
            predict: |_, residuals, predictor| each_pair(residuals, predictor, u8::midpoint),
            ..r
        },
    ),
    // 2.9.6, 2.9.7 and where the planes lie
    extents(
        "planes-in-decode-order",
        "2.9.8/1",
        "takes the planes to be stored in the order in which they are decoded",
        "they are stored in plane order",
        |r| Reading {
            plan: |lists| {
                relaid(lists, |lists, plan| {
                    let mut end = 0;
                    for &i in &plan.sequence {
                        let (stream, side) = (size(&lists.sizes[i]), size(&lists.side_sizes[i]));
                        let (start, middle) = (end, usize::saturating_add(end, stream));
                        end = middle.saturating_add(side);
                        plan.extents[i] = Extent {
                            stream: start..middle,
                            side: middle..end,
                        };
                    }
                })
            },
            ..r
        },
    ),
    extents(
        "sizes-by-rank",
        "2.9.6/1",
        "takes the sizes to stand in the order in which planes are decoded",
        "number i is the size of plane i",
        |r| Reading {
            plan: |lists| {
                relaid(lists, |_, plan| {
                    // The first stream is the one decoded first for such a reader, and so are its sizes.
                    let before = plan.extents.clone();
                    for (place, &i) in plan.sequence.iter().enumerate() {
                        plan.extents[i] = before[place].clone();
                    }
                })
            },
            ..r
        },
    ),
    extents(
        "side-sizes-are-records",
        "2.9.7/1",
        "takes the side information size for a number of records",
        "it counts bytes",
        |r| Reading {
            plan: |lists| {
                relaid(lists, |lists, plan| {
                    sized(plan, |i| {
                        (
                            size(&lists.sizes[i]),
                            size(&lists.side_sizes[i]).saturating_mul(5),
                        )
                    });
                })
            },
            ..r
        },
    ),
    extents(
        "sizes-include-side-information",
        "2.9.6/1",
        "takes the compressed size to include the side information",
        "the two sizes add up",
        |r| Reading {
            plan: |lists| {
                relaid(lists, |lists, plan| {
                    sized(plan, |i| {
                        (
                            size(&lists.sizes[i]).saturating_sub(size(&lists.side_sizes[i])),
                            size(&lists.side_sizes[i]),
                        )
                    });
                })
            },
            ..r
        },
    ),
    extents(
        "side-information-not-skipped",
        "2.9.8/4",
        "looks for the next stream right after a stream",
        "side information stands between them",
        |r| Reading {
            plan: |lists| {
                relaid(lists, |lists, plan| {
                    sized(plan, |i| (size(&lists.sizes[i]), 0));
                })
            },
            ..r
        },
    ),
    extents(
        "side-information-before-its-plane",
        "2.9.8/4",
        "looks for side information before the stream",
        "it follows the stream",
        |r| Reading {
            plan: |lists| {
                relaid(lists, |_, plan| {
                    for extent in &mut plan.extents {
                        let (start, end) = (extent.stream.start, extent.side.end);
                        let side = start..start + extent.side.len();
                        *extent = Extent {
                            stream: side.end..end,
                            side,
                        };
                    }
                })
            },
            ..r
        },
    ),
    extents(
        "side-information-behind-all-planes",
        "2.9.8/4",
        "looks for all side information behind the last stream",
        "each plane is followed by its own",
        |r| Reading {
            plan: |lists| {
                relaid(lists, |_, plan| {
                    let mut end = 0;
                    for extent in &mut plan.extents {
                        extent.stream = end..usize::saturating_add(end, extent.stream.len());
                        end = extent.stream.end;
                    }
                    for extent in &mut plan.extents {
                        extent.side = end..end.saturating_add(extent.side.len());
                        end = extent.side.end;
                    }
                })
            },
            ..r
        },
    ),
    plan(
        "negative-side-size-is-none",
        "2.9.7/3",
        "takes a negative side information size for none",
        "refuse it",
        |r| Reading {
            plan: |lists| {
                let mut lists = lists.clone();
                lists
                    .side_sizes
                    .iter_mut()
                    .for_each(|size| size.value = size.value.max(0));
                compressed::plan(&lists)
            },
            ..r
        },
    ),
    // 2.9.8: which plane is which
    channels(
        "rgb-planes-coefficient-major",
        "takes the planes of RGB for a0 of red, green, blue, then a1",
        |ptm| rearranged(ptm, 18, |channel| channel % 6 * 3 + channel / 6),
    ),
    channels(
        "rgb-planes-bgr",
        "takes the first six planes of RGB for blue",
        |ptm| rearranged(ptm, 18, |channel| (2 - channel / 6) * 6 + channel % 6),
    ),
    channels(
        "lrgb-planes-colors-first",
        "takes the first three planes of LRGB for colors",
        |ptm| rearranged(ptm, 9, |channel| (channel + 3) % 9),
    ),
    channels(
        "lrgb-planes-bgr",
        "takes the last planes of LRGB for B, G, R",
        |ptm| {
            rearranged(
                ptm,
                9,
                |channel| if channel < 6 { channel } else { 14 - channel },
            );
        },
    ),
    channels(
        "lrgb-planes-backwards",
        "takes the six planes of LRGB for a5 to a0",
        |ptm| {
            rearranged(
                ptm,
                9,
                |channel| if channel < 6 { 5 - channel } else { channel },
            );
        },
    ),
];

const fn plan(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend,
        at: At::Reading(Decision::Plan, change),
    }
}

/// A mistake in what is done to a plane's reference.
const fn steps(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    plan(slug, clause, effect, mend, change)
}

/// A mistake in the motion vectors.
const fn vectors(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    plan(slug, clause, effect, mend, change)
}

/// A mistake in where the planes lie.
const fn extents(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    plan(slug, clause, effect, mend, change)
}

const fn invert(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause: "2.9.2/3",
        effect,
        mend: "the inverse of v is 255 − v",
        at: At::Reading(Decision::Invert, change),
    }
}

const fn predictor(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend,
        at: At::Reading(Decision::Predictor, change),
    }
}

const fn predict_as(
    slug: &'static str,
    effect: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    let mend = "the plane is residual + predictor − 128, modulo 256";
    Misreading {
        slug,
        clause: "2.9.5/4",
        effect,
        mend,
        at: At::Reading(Decision::Predict, change),
    }
}

pub(super) const fn reconstruct(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend,
        at: At::Reading(Decision::Reconstruct, change),
    }
}

const fn channels(slug: &'static str, effect: &'static str, edit: fn(&mut Ptm)) -> Misreading {
    let mend = "planes run from a0 to a5, of red, green and blue; or of luminance, then R, G, B";
    Misreading {
        slug,
        clause: "2.9.8/1",
        effect,
        mend,
        at: At::Planes(edit),
    }
}

/// The plan with another step for each plane.
fn changed(lists: &RawLists, change: fn(&RawLists, usize, Step) -> Step) -> Result<Plan> {
    let mut plan = compressed::plan(lists)?;
    for (i, step) in plan.steps.iter_mut().enumerate() {
        *step = change(lists, i, *step);
    }
    Ok(plan)
}

/// The plan with another vector for each plane, of all numbers of 2.9.3, the plane and the vector it should be.
fn displacing(
    lists: &RawLists,
    change: fn(&[Number], usize, (i64, i64)) -> (i64, i64),
) -> Result<Plan> {
    let mut plan = compressed::plan(lists)?;
    for (i, step) in plan.steps.iter_mut().enumerate() {
        // Beyond any plane, and far from where arithmetic ends.
        let (x, y) = change(
            &lists.motion,
            i,
            (bounded(step.motion.0), bounded(step.motion.1)),
        );
        step.motion = (bounded(x), bounded(y));
    }
    Ok(plan)
}

fn bounded(displacement: i64) -> i64 {
    displacement.clamp(-(1 << 40), 1 << 40)
}

/// The plan with the planes in other places.
fn relaid(lists: &RawLists, change: fn(&RawLists, &mut Plan)) -> Result<Plan> {
    let mut plan = compressed::plan(lists)?;
    change(lists, &mut plan);
    Ok(plan)
}

/// Lays the planes one behind another with other sizes.
fn sized(plan: &mut Plan, sizes: impl Fn(usize) -> (usize, usize)) {
    let mut end = 0usize;
    for (i, extent) in plan.extents.iter_mut().enumerate() {
        let (stream, side) = sizes(i);
        let (start, middle) = (end, end.saturating_add(stream));
        end = middle.saturating_add(side);
        *extent = Extent {
            stream: start..middle,
            side: middle..end,
        };
    }
}

/// The plan of a reader that takes other numbers for the references, and checks them as it should.
fn referring(lists: &RawLists, change: impl Fn(usize, i64) -> i64) -> Result<Plan> {
    let mut lists = lists.clone();
    for (i, reference) in lists.references.iter_mut().enumerate() {
        reference.value = change(i, reference.value);
    }
    compressed::plan(&lists)
}

/// The same of a reader that does not look at their ranks.
fn referring_to(lists: &RawLists, change: impl Fn(usize, i64) -> i64) -> Result<Plan> {
    let sequence = compressed::plan(lists)?.sequence;
    let mut lists = lists.clone();
    for (i, reference) in lists.references.iter_mut().enumerate() {
        reference.value = change(i, reference.value);
    }
    Ok(Plan {
        sequence,
        ..unranked(&lists)?
    })
}

/// The plan of a reader that does not look at ranks: planes in plane order, from references that may come later. What is
/// not decoded yet is full of zeros.
fn unranked(lists: &RawLists) -> Result<Plan> {
    let mut intra = lists.clone();
    intra
        .references
        .iter_mut()
        .for_each(|reference| reference.value = -1);
    let mut plan = compressed::plan(&intra)?;
    for (step, reference) in plan.steps.iter_mut().zip(&lists.references) {
        step.reference = if reference.value < 0 {
            None
        } else {
            Some(plane(lists, reference)?)
        };
    }
    plan.sequence.sort_unstable();
    Ok(plan)
}

/// The order list as planes.
fn listed(lists: &RawLists) -> Result<Vec<usize>> {
    let numbers = lists.order.iter();
    numbers.map(|number| plane(lists, number)).collect()
}

/// The plane of that number, if there is one.
fn plane(lists: &RawLists, number: &Number) -> Result<usize> {
    let planes = lists.format.channels();
    let found = usize::try_from(number.value)
        .ok()
        .filter(|&plane| plane < planes);
    found.ok_or_else(|| refused(number))
}

fn refused(number: &Number) -> Error {
    Error::new(
        "2.9/1",
        number.at,
        Kind::Expected {
            what: "another number",
            found: number.value.to_string(),
        },
    )
}

/// A size that has been found to be none or more bytes.
fn size(number: &Number) -> usize {
    number.value.max(0) as usize
}

/// All planes, each made of its residuals by `make`, then mended.
fn planes(
    coded: &Coded,
    reading: &Reading,
    make: impl Fn(usize, &mut [u8], &[Vec<u8>], &[Step]),
) -> Result<Vec<Vec<u8>>> {
    let mut done = coded.blank_planes();
    for &i in &coded.plan.sequence {
        let mut plane = coded.residuals(i, reading)?;
        make(i, &mut plane, &done, &coded.plan.steps);
        coded.mend(i, &mut plane, reading)?;
        done[i] = plane;
    }
    Ok(done)
}

/// Predicts plane `i` as `step` says.
fn predict(coded: &Coded, reading: &Reading, plane: &mut [u8], done: &[Vec<u8>], step: Step) {
    if let Some(reference) = step.reference {
        rule::apply(
            coded.format,
            plane,
            &done[reference],
            &step,
            coded.size,
            reading,
        );
    }
}

/// The reference as the rule has it, but with another way to find a sample at (x, y), in the plane or outside of it.
fn displaced<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
    sample: fn(&[u8], x: i64, y: i64, width: i64, height: i64) -> u8,
) -> Cow<'a, [u8]> {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let taps: Taps = |at, [d, _], _| [at + (d >> 1), at + (d >> 1) + (d & 1)];
    walked(reference, step, size, reading, taps, |still, x, y| {
        sample(still, x, y, width, height)
    })
}

/// One axis of a plane.
struct Axis {
    is_x: bool,
    /// Samples along it.
    length: i64,
    /// Samples along the other one.
    other: i64,
}

/// Where the two samples stand of which one is made along an axis: of where it is, and how many half texels this axis and
/// the other one are displaced.
type Taps = fn(at: i64, displacements: [i64; 2], &Axis) -> [i64; 2];

/// The reference as the rule has it, but with other places for the samples of which one is made.
fn tapped<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
    taps: Taps,
) -> Cow<'a, [u8]> {
    walked(reference, step, size, reading, taps, |still, x, y| {
        let x = (reading.motion_border)(x, size.width);
        let y = (reading.motion_border)(y, size.height);
        x.zip(y)
            .map_or(128, |(x, y)| still[y * size.width as usize + x])
    })
}

/// The reference with every sample the mean of four, which `taps` place and `sample` finds.
fn walked<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
    taps: Taps,
    sample: impl Fn(&[u8], i64, i64) -> u8,
) -> Cow<'a, [u8]> {
    let still = Step {
        moved: false,
        ..*step
    };
    let still = rule::inverted_then_moved(reference, &still, size, reading);
    if !step.moved || step.motion == (0, 0) {
        return still;
    }
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let (mx, my) = (
        bounded((reading.motion_sign)(step.motion.0)),
        bounded((reading.motion_sign)((reading.motion_vertical)(
            step.motion.1,
        ))),
    );
    let [along, across] =
        [(true, width, height), (false, height, width)].map(|(is_x, length, other)| Axis {
            is_x,
            length,
            other,
        });
    let texel = |(x, y): (i64, i64)| {
        let [left, right] = taps(x, [mx, my], &along);
        let [upper, lower] = taps(y, [my, mx], &across);
        let at = |x, y| sample(&still, x, y);
        (reading.motion_half)([
            at(left, upper),
            at(right, upper),
            at(left, lower),
            at(right, lower),
        ])
    };
    Cow::Owned(
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(texel)
            .collect(),
    )
}

/// Takes channel `from(i)` for channel `i` of every texel of a compressed file of so many planes.
fn rearranged(ptm: &mut Ptm, planes: usize, from: fn(usize) -> usize) {
    if ptm.header.format.is_compressed() && ptm.header.format.channels() == planes {
        for texel in ptm.planes.samples.chunks_exact_mut(planes) {
            let stored = texel.to_vec();
            texel
                .iter_mut()
                .enumerate()
                .for_each(|(i, value)| *value = stored[from(i)]);
        }
    }
}

fn each(plane: &mut [u8], change: impl Fn(u8) -> u8) {
    for value in plane {
        *value = change(*value);
    }
}

fn each_pair(plane: &mut [u8], predictor: &[u8], change: fn(u8, u8) -> u8) {
    plane
        .iter_mut()
        .zip(predictor)
        .for_each(|(value, &predicted)| *value = change(*value, predicted));
}

/// Residual + predictor − 128, before anything wraps.
fn sum(value: u8, predicted: u8) -> i16 {
    i16::from(value) + i16::from(predicted) - 128
}

fn clamped(sum: i16) -> u8 {
    sum.clamp(0, 255) as u8
}
