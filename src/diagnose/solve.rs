//! Solves, from wrong pictures, what was done to them: mistakes that no list has.
//!
//! Painted values know where each came from. From the smallest failing files of each format candidates are read off the
//! answers; each is then held against all failing files, and against the passing ones that could deny it. Where these do,
//! what the failing files share tells in which files the mistake is made.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::codecs::evidence::CODECS;
use super::codecs::fits::fitting;
use super::codecs::stream_slips::StreamSlip;
use super::files::scope::Scope;
use super::files::shared::shared;
use super::layout::indices::{Index, IndexBlock};
use super::layout::strides::Strides;
use super::layout::table_layouts::TableLayout;
use super::mistake::Mistake;
use super::planes;
use super::planes::slips::PlaneSlip;
use super::search::{Id, Search, Set, WORD, spread};
use super::solve_file::candidates;
use super::solved::{Act, Solved};
use super::values::changes::{Change, merged};
use super::values::color_rules::ColorRule;
use super::values::final_rules::FinalRule;
use super::values::number_readers::NumberReader;
use super::values::solve_powers;
use super::values::solve_terms;
use super::values::variants::VARIANTS;
use super::witness::{Agreement, Witness};
use crate::misreadings::Stage;
use crate::protocol::frame::{Answer, View};
use crate::ptm::Format;
use crate::suite::cases::Expect;

/// Fewer pictures than these tell nothing that could be held against others.
const FEWEST: usize = 2;
/// Fewer pictures tell nothing of some files alone; under a light, where colors are rounded, still more are needed.
const FEWEST_NARROW: usize = 4;
const FEWEST_COLORS: usize = 6;
/// Failing files that candidates are read off.
const FILES: usize = 40;
/// Candidates that are held against some failing files, and against all.
const MOST: usize = 240;
const FINALISTS: usize = 20;
/// The same of many candidates: first a few files.
const FIRST_FILES: usize = 8;
const FIRST_FINALISTS: usize = 200;
const FEW_FINALISTS: usize = 6;
/// Mistakes of the catalog of which is solved where they are made.
const NARROW: usize = 12;
/// Files of a codec under a light that every slip in its decoder is tried on, and those that are tried on more; and the slips
/// that are held against all files.
const FIRST_STREAMS: usize = 4;
const STREAMS: usize = 12;
const FEW_SLIPS: usize = 3;
/// So often slips in decoders of streams are looked for.
const SLIPS: usize = 3;
/// Samples of all these files together.
const SAMPLES: usize = 1 << 18;

/// Adds to the mistakes of `search` those that explain some of `left` beside `set`. Returns those that are made together.
pub(super) fn solve(search: &mut Search, set: &Set, left: &[usize]) -> Vec<Set> {
    looked_up(search, set, left);
    let slipped = slipped(search, set, left);
    let pictures = search.solvable(left);
    if pictures.len() < FEWEST || !slipped.is_empty() {
        return slipped;
    }
    let kind = |w: usize| {
        let witness = &search.witnesses[w];
        (witness.case.format(), witness.observation.view.name())
    };
    let mut sample = spread(&search.smallest(&pictures, SAMPLES), kind);
    sample.truncate(FILES);
    let found = search.each(&sample, |&w| {
        let found = catch_unwind(AssertUnwindSafe(|| candidates(search, set, w)));
        found.unwrap_or_else(|panic| {
            search.note(&*panic);
            Vec::new()
        })
    });
    let (alone, together): (Vec<Vec<Act>>, Vec<Vec<Act>>) = found
        .into_iter()
        .flatten()
        .partition(|group| group.len() == 1);
    let known = search.mistakes.len();
    let alone = distinct(alone.into_iter().flatten().collect());
    let mut of_terms = solve_terms::candidates(search, set, &pictures);
    of_terms.extend(solve_powers::candidate(search, set, &pictures));
    let new = alone.into_iter().filter(|act| !is_known(search, act));
    let of_terms = of_terms.into_iter().filter(|act| !is_known(search, act));
    let new: Vec<Act> = new.take(MOST).chain(of_terms).collect();
    let best = finalists(search, set, &sample, new, (FINALISTS, 1));
    search.truncate(known);
    for act in best {
        add(search, set, &pictures, act);
    }
    let rebuilt = rebuilt(search, set, &pictures);
    computed(search, set, &pictures);
    narrow(search, set, &sample, &pictures);
    let mut groups: Vec<Set> = Vec::new();
    for group in rebuilt
        .into_iter()
        .chain(together.into_iter().take(FINALISTS))
    {
        let ids: Set = group.into_iter().map(|act| id_of(search, act)).collect();
        if !groups.contains(&ids) {
            groups.push(ids);
        }
    }
    groups
}

/// Adds wrong ways to look up an index. Most of them lead out of the table, and no picture is shown.
fn looked_up(search: &mut Search, set: &Set, left: &[usize]) {
    let has_table = |witness: &Witness| witness.case.format().has_table();
    let mut tables = left.to_vec();
    tables.retain(|&w| has_table(&search.witnesses[w]));
    if tables.is_empty() {
        return;
    }
    let layouts = TableLayout::all().map(Act::Table);
    let with_table = search.witnesses.iter().filter(|&one| has_table(one));
    let blocks = with_table.filter_map(IndexBlock::of);
    let entries: BTreeSet<usize> = blocks.map(|block| block.entries().len()).collect();
    let entries: Vec<usize> = entries.into_iter().collect();
    let indices = Index::widths(&entries).chain(Index::all());
    try_all(search, set, &tables, layouts.chain(indices.map(Act::Index)));
}

/// Adds slips in the decoders of streams; returns those that are made together.
fn slipped(search: &mut Search, set: &Set, left: &[usize]) -> Vec<Set> {
    search.looked_for_slips += 1;
    if search.looked_for_slips > SLIPS {
        return Vec::new();
    }
    let known = search.mistakes_of(set);
    let before = known.iter().filter_map(|one| match one.solved()?.act {
        Act::Stream(slip) => Some(slip),
        _ => None,
    });
    let before: Vec<StreamSlip> = before.collect();
    let mut together = Vec::new();
    for formats in CODECS.map(|codec| codec.formats) {
        let is_of = |w: &usize| formats.contains(&search.witnesses[*w].case.format());
        let is_legal = |w: &usize| search.witnesses[*w].case.expect == Expect::Decode;
        let of: Vec<usize> = (left.iter().copied())
            .filter(|w| is_of(w) && is_legal(w))
            .collect();
        let before: Vec<StreamSlip> = (before.iter().copied())
            .filter(|slip| slip.is_of(formats[0]))
            .collect();
        let is_color = |w: &usize| search.witnesses[*w].is_in_colors();
        if of.iter().all(is_color) {
            slipped_colors(search, set, &of, formats[0]);
        }
        for slips in fitting(search, formats, &before, &of) {
            match slips[..] {
                [slip] if is_known(search, &Act::Stream(slip)) => {}
                [slip] => add(search, set, &of, Act::Stream(slip)),
                _ => {
                    let acts = slips.into_iter().map(Act::Stream);
                    together.push(acts.map(|act| id_of(search, act)).collect());
                }
            }
        }
    }
    together
}

/// The same where colors are shown, which tell less: every slip is tried on the smallest files, and the best on more.
fn slipped_colors(search: &mut Search, set: &Set, of: &[usize], format: Format) {
    let mut pictures = search.smallest(&search.solvable(of), SAMPLES);
    pictures.truncate(STREAMS);
    let slips = StreamSlip::all().filter(|slip| slip.is_of(format));
    let new = slips.map(Act::Stream).filter(|act| !is_known(search, act));
    let new: Vec<Act> = new.collect();
    let known = search.mistakes.len();
    let first = &pictures[..pictures.len().min(FIRST_STREAMS)];
    let first = finalists(search, set, first, new, (FIRST_FINALISTS, WORD + 1));
    search.truncate(known);
    let best = finalists(search, set, &pictures, first, (FEW_SLIPS, WORD + 1));
    search.truncate(known);
    for act in best {
        add(search, set, of, act);
    }
}

/// Adds slips in how planes are rebuilt. Returns those that are made together.
fn rebuilt(search: &mut Search, set: &Set, pictures: &[usize]) -> Option<Vec<Act>> {
    let slips = planes::solve::candidates(search, set, pictures);
    let acts: Vec<Act> = slips.into_iter().map(Act::Planes).collect();
    let new: Vec<Act> = (acts.iter())
        .filter(|act| !is_known(search, act))
        .cloned()
        .collect();
    for act in new {
        add(search, set, pictures, act);
    }
    if acts.is_empty() {
        let is_compressed = |w: &usize| search.witnesses[*w].case.format().is_compressed();
        let of: Vec<usize> = pictures.iter().copied().filter(is_compressed).collect();
        let others = PlaneSlip::of_other_planes().map(Act::Planes);
        try_all(search, set, &of, others);
    }
    (acts.len() > 1).then_some(acts)
}

/// Adds wrong ways to read numbers and to compute, where values are computed.
fn computed(search: &mut Search, set: &Set, pictures: &[usize]) {
    let of = |view: fn(&View) -> bool| -> Vec<usize> {
        let is_of = |w: &usize| view(&search.witnesses[*w].observation.view);
        pictures.iter().copied().filter(is_of).collect()
    };
    let finals = of(|view| *view != View::Raw);
    let colors = of(|view| matches!(view, View::Rgb(_)));
    let rules = FinalRule::all().map(Act::Rule);
    try_all(
        search,
        set,
        &finals,
        NumberReader::all().map(Act::Numbers).chain(rules),
    );
    let variants = (0..VARIANTS.len()).map(Act::Variant);
    let rules = ColorRule::all().map(Act::Color);
    try_all(search, set, &colors, variants.chain(rules));
}

/// Adds those of `acts` that explain most of the files `of`.
fn try_all(search: &mut Search, set: &Set, of: &[usize], acts: impl Iterator<Item = Act>) {
    if of.len() < FEWEST_NARROW {
        return;
    }
    let kind = |w: usize| search.witnesses[w].case.clauses.first().cloned();
    let mut sample = spread(&search.smallest(of, SAMPLES), kind);
    sample.truncate(FILES);
    let new: Vec<Act> = acts.filter(|act| !is_known(search, act)).collect();
    let known = search.mistakes.len();
    // Most of many are out on a few files.
    let first = &sample[..sample.len().min(FIRST_FILES)];
    let new = finalists(search, set, first, new, (FIRST_FINALISTS, 1));
    search.truncate(known);
    let best = finalists(search, set, &sample, new, (FEW_FINALISTS, 2 * WORD));
    search.truncate(known);
    for act in best {
        add(search, set, of, act);
    }
}

/// Each once; tables that do not contradict each other as one.
fn distinct(acts: Vec<Act>) -> Vec<Act> {
    let mut distinct: Vec<Act> = Vec::new();
    for act in acts {
        let joined = distinct.iter_mut().any(|known| match (known, &act) {
            (
                Act::Stored {
                    channels: known_channels,
                    change: Change::Table(known),
                },
                Act::Stored {
                    channels,
                    change: Change::Table(table),
                },
            ) if known_channels == channels => match merged(known, table) {
                Some(both) => {
                    *known = both;
                    true
                }
                None => false,
            },
            (known, act) => known == act,
        });
        if !joined {
            distinct.push(act);
        }
    }
    distinct
}

fn is_known(search: &Search, act: &Act) -> bool {
    let mut solved = search.mistakes.iter().filter_map(Mistake::solved);
    solved.any(|solved| solved.act == *act)
}

fn id_of(search: &mut Search, act: Act) -> Id {
    let is_it = |mistake: &Mistake| {
        mistake
            .solved()
            .is_some_and(|solved| solved.act == act && solved.scope == Scope::All)
    };
    match search.mistakes.iter().position(is_it) {
        Some(id) => id,
        None => search.add(Mistake::Solved(Solved {
            act,
            scope: Scope::All,
        })),
    }
}

/// Those of `acts` that are worth most on the sample: so many of them, and none that is worth less.
fn finalists(
    search: &mut Search,
    set: &Set,
    sample: &[usize],
    acts: Vec<Act>,
    (most, least): (usize, i64),
) -> Vec<Act> {
    let first = search.mistakes.len();
    let count = acts.len();
    for act in acts {
        search.add(Mistake::Solved(Solved {
            act,
            scope: Scope::All,
        }));
    }
    let ids: Vec<Id> = (first..first + count).collect();
    let gains = search.each(&ids, |&id| {
        let with = [&set[..], &[id]].concat();
        let gain = |&w: &usize| (search.value(w, &with) - search.value(w, set)).max(0);
        sample.iter().map(gain).sum::<i64>()
    });
    let mut ranked: Vec<(i64, Id)> = gains
        .into_iter()
        .zip(ids)
        .filter(|&(gain, _)| gain >= least)
        .collect();
    ranked.sort_by_key(|&(gain, id)| (-gain, id));
    ranked.truncate(most);
    let act = |(_, id): (i64, Id)| {
        search.mistakes[id]
            .solved()
            .map(|solved| solved.act.clone())
    };
    ranked.into_iter().filter_map(act).collect()
}

/// Adds `act` in the files in which it is made, if these can be told and most of them show it.
fn add(search: &mut Search, set: &Set, pictures: &[usize], act: Act) {
    let id = search.add(Mistake::Solved(Solved {
        act: act.clone(),
        scope: Scope::All,
    }));
    let with = [&set[..], &[id]].concat();
    let gains = search.each(pictures, |&w| {
        let value = search.value(w, &with);
        (value - search.value(w, set), value)
    });
    let explained = |least: i64| -> Vec<usize> {
        let pairs = pictures.iter().zip(&gains);
        let enough = pairs.filter(|&(_, &(gain, value))| gain > 0 && value >= least);
        enough.map(|(&w, _)| w).collect()
    };
    let (whole, part) = (explained(WORD), explained(1));
    let of = if whole.is_empty() { part } else { whole };
    let denied = search.denied(&with);
    let scope = match denied.is_empty() {
        true => Some(Scope::All),
        false => scope_of(search, &of, &denied).filter(|scope| may_depend(&act, scope)),
    };
    let acting = search.each(pictures, |&w| {
        let holds = |scope: &Scope| scope.holds(&search.witnesses[w]);
        scope.as_ref().is_some_and(holds) && search.made(w, &with) != search.made(w, set)
    });
    let acting = acting.into_iter().filter(|acts| *acts).count();
    let is_picture = |&w: &usize| search.agreement(w, &with) == Agreement::Picture;
    let seen = match act {
        // It was held against all pictures before.
        Act::Stream(_) => true,
        _ => of.iter().any(is_picture),
    };
    search.truncate(id);
    let is_shown = is_shown(search, &of, acting, scope.as_ref());
    // Many things end in a refusal: one picture at least has to be just so.
    let is_seen = seen || !act.may_refuse();
    // Some pictures under some lights agree with something by chance.
    let is_color = |&w: &usize| search.witnesses[w].is_in_colors();
    let is_of_some = !matches!(scope, None | Some(Scope::All | Scope::Formats(_)));
    let is_chance = is_of_some && of.iter().all(is_color) && of.len() * 2 < pictures.len();
    if let Some(scope) = scope
        && is_shown
        && is_seen
        && !is_chance
        && !(of.len() == 1 && is_doubtful(search, of[0], &act))
        && !(is_of_strides(&act) && of.iter().all(|&w| is_narrow(search, w)))
    {
        search.add(Mistake::Solved(Solved { act, scope }));
    }
}

/// Whether it may depend on what these files share that something is done in them.
fn may_depend(act: &Act, scope: &Scope) -> bool {
    let of_view = match (act.shows_in(&View::Raw), act.shows_in(&View::Coef)) {
        (true, _) => !scope.is_of_numbers(),
        (_, true) => !scope.is_of_bytes(),
        _ => !scope.is_of_bytes() && !scope.is_of_numbers(),
    };
    // A header is read alike whatever follows it, and so are streams.
    let is_read_alike = matches!(
        act,
        Act::Numbers(_) | Act::OtherNumbers(_) | Act::Stream(_) | Act::Planes(_)
    );
    // Of a value alone nothing depends on how much of something else a file has.
    let of_amount = !matches!(scope, Scope::Beyond { .. }) || !act.is_of_values();
    let of_values = matches!(scope, Scope::Formats(_)) || !act.is_of_few_values();
    let of_light = !(scope.is_of_light() && act.shows_in(&View::Coef));
    of_view && of_light && of_amount && of_values && !is_read_alike
}

/// Adds mistakes of the catalog that passing cases deny, in the files in which they are made, if these can be told.
fn narrow(search: &mut Search, set: &Set, sample: &[usize], pictures: &[usize]) {
    let is_open = |id: &Id| {
        matches!(search.mistakes[*id], Mistake::Listed(_))
            && !set.contains(id)
            && !search.assumed.contains(id)
    };
    let open: Vec<Id> = (0..search.mistakes.len()).filter(is_open).collect();
    let explains = |id: Id, w: usize| {
        let with = [&set[..], &[id]].concat();
        search.value(w, &with) >= WORD && search.value(w, set) < WORD
    };
    let counts = search.each(&open, |&id| {
        sample.iter().filter(|&&w| explains(id, w)).count()
    });
    let mut ranked: Vec<(usize, Id)> = counts.into_iter().zip(open).collect();
    ranked.retain(|&(count, _)| count >= FEWEST);
    ranked.sort_by_key(|&(count, id)| (Reverse(count), id));
    ranked.truncate(NARROW);
    let best: Vec<Id> = ranked.into_iter().map(|(_, id)| id).collect();
    let scopes = search.each(&best, |&id| scope_of_listed(search, set, id, pictures));
    for (id, scope) in best.into_iter().zip(scopes) {
        if let (Some(scope), Some(misreading)) = (scope, search.mistakes[id].listed()) {
            search.add(Mistake::Narrow(misreading, scope));
        }
    }
}

/// Whether what is made in such files only is rather another mistake than one of the catalog: where two things come together,
/// or from a number on.
fn is_of_other_mistakes(scope: &Scope) -> bool {
    matches!(scope, Scope::Both(..) | Scope::Beyond { .. })
}

/// In which files a mistake of the catalog is made that passing cases deny.
fn scope_of_listed(search: &Search, set: &Set, id: Id, pictures: &[usize]) -> Option<Scope> {
    let with = [&set[..], &[id]].concat();
    let denied = search.denied(&with);
    if denied.is_empty() {
        return None;
    }
    let explains = |w: &usize| search.value(*w, &with) >= WORD && search.value(*w, set) < WORD;
    let explained: Vec<usize> = pictures.iter().copied().filter(explains).collect();
    let scope =
        scope_of(search, &explained, &denied).filter(|scope| !is_of_other_mistakes(scope))?;
    let misreading = search.mistakes[id].listed()?;
    let acts = |w: &&usize| {
        scope.holds(&search.witnesses[**w]) && search.made(**w, &with) != search.made(**w, set)
    };
    let acting = pictures.iter().filter(acts).count();
    let stage = misreading.at.stage();
    let is_of_files = (stage == Stage::Color || !scope.is_of_light())
        && (stage < Stage::Coefficients || !scope.is_of_bytes());
    let is_made = is_of_files
        && explained.len() > FEWEST
        && explained.len() * 4 >= pictures.len()
        && explained.len() * 3 >= acting
        && is_shown(search, &explained, acting, Some(&scope));
    is_made.then_some(scope)
}

/// Whether the pictures `of` are enough of those on which a mistake with this scope acts. Colors are rounded, and agree by
/// chance with many a mistake.
fn is_shown(search: &Search, of: &[usize], acting: usize, scope: Option<&Scope>) -> bool {
    let is_color = |w: &usize| search.witnesses[*w].is_in_colors();
    let colors_only = of.iter().all(is_color);
    let narrow = !matches!(scope, Some(Scope::All | Scope::Formats(_)));
    let fewest = match (narrow, colors_only) {
        (true, true) => FEWEST_COLORS,
        (true, false) => FEWEST_NARROW,
        (false, _) => 1,
    };
    // Where a mistake is made in some files, it shows in most of these.
    let (most, part) = match (narrow, colors_only) {
        (_, true) => (4, 7),
        (true, false) => (1, 2),
        (false, false) => (1, 10),
    };
    of.len() >= fewest && of.len() * part >= acting * most
}

/// What the explained files share, and none of those that deny the mistake has.
fn scope_of(search: &Search, explained: &[usize], denied: &[usize]) -> Option<Scope> {
    let format = |w: &usize| search.witnesses[*w].case.format();
    if explained.len() >= 2
        && !explained
            .iter()
            .any(|w| denied.iter().any(|d| format(d) == format(w)))
    {
        // A format that neither shows it nor denies it is as those are whose values mean the same.
        let shown: Vec<Format> = explained.iter().map(format).collect();
        let others: Vec<Format> = denied.iter().map(format).collect();
        let is_like =
            |of: &[Format], one: Format| of.iter().any(|other| other.channels() == one.channels());
        let mut formats = Format::ALL.to_vec();
        formats
            .retain(|&one| shown.contains(&one) || is_like(&shown, one) && !is_like(&others, one));
        return Some(Scope::Formats(formats));
    }
    let shared = shared(search.witnesses, explained, denied, true)?;
    (shared.of.len() * 4 >= explained.len() * 3).then_some(shared.scope)
}

/// Whether it is where values stand, other than so many places on.
fn is_of_strides(act: &Act) -> bool {
    match act {
        Act::Block { strides, .. } | Act::Texels { strides, .. } => {
            *strides != Strides::RIGHT.moved(strides.shift)
        }
        _ => false,
    }
}

/// Whether a map has so few columns or rows that one order of them is like another.
fn is_narrow(search: &Search, w: usize) -> bool {
    match &search.witnesses[w].right {
        Answer::Decoded(frame) => frame.width < 3 || frame.height < 3,
        _ => true,
    }
}

/// Whether one file alone does not show it: colors are rounded, and tables have many entries.
fn is_doubtful(search: &Search, w: usize, act: &Act) -> bool {
    let is_free = match act {
        Act::Stored { change, .. } | Act::Final { change, .. } | Act::Shown { change, .. } => {
            !matches!(
                change,
                Change::Offset(_) | Change::Xor(_) | Change::Inverted
            )
        }
        _ => false,
    };
    is_free || search.witnesses[w].is_in_colors()
}
