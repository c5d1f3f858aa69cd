//! Several slips in one expression.
//!
//! An expression has parts, and for each part stands a list of what may be written there, the right one first. All
//! combinations are tried, those with the fewest slips first.

/// What is written in each part, as places in their lists.
pub(in crate::diagnose) type Places<const N: usize> = [usize; N];

/// All combinations of lists of these lengths but the right one, which has the first of each.
pub(in crate::diagnose) fn all<const N: usize>(
    lengths: [usize; N],
) -> impl Iterator<Item = Places<N>> {
    let mut all: Vec<Places<N>> = (1..lengths.iter().product())
        .map(|mut place: usize| {
            lengths.map(|length| {
                let digit = place % length;
                place /= length;
                digit
            })
        })
        .collect();
    all.sort_by_key(|places| places.iter().filter(|&&place| place > 0).count());
    all.into_iter()
}
