//! Ways that cost little to try.

use agrik::chain::JointKind;

use super::ask::Ask;
use super::words::How;

/// Ways from one posture to another without anything in between but where one slide moves
/// alone, the straight one first; the postures in between of the first that is free.
pub(super) fn direct(ask: &mut Ask<'_>, from: &[f64], to: &[f64]) -> Option<(How, Vec<Vec<f64>>)> {
    if ask.free(from, to) {
        return Some((How::Straight, Vec::new()));
    }
    let variables = ask.collider().bodies().chain().variables();
    let slides = variables.iter().enumerate().filter(|(_, v)| v.kind == JointKind::Prismatic);
    for (slide, _) in slides {
        for (how, base, other) in [(How::SlideFirst, from, to), (How::SlideLast, to, from)] {
            if base[slide] == other[slide] {
                continue;
            }
            let mut between = base.to_vec();
            between[slide] = other[slide];
            // The one in which the slide alone moves is seldom the one that is not free.
            let (first, second) = ((from, &between[..]), (&between[..], to));
            let order = if how == How::SlideFirst { [second, first] } else { [first, second] };
            if order.iter().all(|(a, b)| ask.free(a, b)) {
                return Some((how, vec![between]));
            }
        }
    }
    None
}

/// The same with a line out of the goal at the end.
pub(super) const fn with_line(how: How) -> How {
    match how {
        How::Straight => How::RetreatStraight,
        How::SlideFirst => How::RetreatSlideFirst,
        How::SlideLast => How::RetreatSlideLast,
        How::RrtConnect => How::RetreatRrtConnect,
        other => other,
    }
}
