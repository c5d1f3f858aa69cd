//! Partial credit for a mistake that explains only some channels of an image.

use super::pair::ImagePair;
use super::tuning::{MIN_SUPPORT, PARTIAL_IMAGE_WORTH};
use super::witness::Witness;
use crate::protocol::frame::Answer;

/// Returns a fraction of [`PARTIAL_IMAGE_WORTH`]: the share of wrong channels that `answer` reproduces. Returns
/// 0 if the answer spoils a correct channel.
pub(super) fn partial_credit(witness: &Witness, answer: &Answer) -> i64 {
    let (Some(received), Answer::Decoded(right), Answer::Decoded(made)) =
        (witness.wrong_image(), &witness.right, answer)
    else {
        return 0;
    };
    let (Some(right), Some(made)) = (
        ImagePair::new(right, received),
        ImagePair::new(made, received),
    ) else {
        return 0;
    };
    if right.width * right.height < MIN_SUPPORT {
        return 0;
    }
    let (before, after) = (right.wrong_channels(), made.wrong_channels());
    let channels = || before.iter().zip(&after);
    let spoiled = channels().any(|(before, after)| !before && *after);
    let fixed = channels()
        .filter(|(before, after)| **before && !**after)
        .count();
    let wrong = before.iter().filter(|is| **is).count();
    match spoiled || wrong == 0 {
        true => 0,
        false => (fixed * PARTIAL_IMAGE_WORTH / wrong) as i64,
    }
}
