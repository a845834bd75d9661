//! The best set of each size against its cost, as a picture and as tables.

use maud::{Markup, html};

use super::tables::plain;
use crate::report::html::facts::front::{DrawnStep, FrontFacts, Picture};

pub(super) fn front(front: &FrontFacts) -> Markup {
    html! {
        div #front {
            figure {
                (drawn(&front.picture))
                figcaption {
                    "A point is the best set of at most so many sensors, full where it is proven; the line from it, \
                     dashed where it is not proven, is what no set of at most as many for that cost or less is above."
                }
            }
            ul { @for note in &front.notes { li { (note) } } }
            @for table in &front.tables { (plain(table)) }
        }
    }
}

fn drawn(picture: &Picture) -> Markup {
    let Picture { size: [width, height], edges: [left, top, right, bottom], across, up, steps } = picture;
    html! {
        svg viewBox={ "0 0 " (width) " " (height) } role="img" aria-label={ (across.title) " against " (up.title) } {
            @for (x, words) in &across.marks {
                path.mesh d={ "M" (x) " " (top) "V" (bottom) } {}
                text x=(x) y=(bottom + 18.0) text-anchor="middle" { (words) }
            }
            @for (y, words) in &up.marks {
                path.mesh d={ "M" (left) " " (y) "H" (right) } {}
                text x=(left - 8.0) y=(y + 4.0) text-anchor="end" { (words) }
            }
            text x=(right) y=(height - 8.0) text-anchor="end" { (across.title) }
            text x="6" y=(top + 10.0) { (up.title) }
            @for step in steps { (point(step)) }
        }
    }
}

fn point(step: &DrawnStep) -> Markup {
    let [x, y] = step.at;
    let (class, filled) = if step.proven { ("proven", step.colour) } else { ("open", "#fff") };
    let dashes = (!step.proven).then_some("6 4");
    html! {
        @if let Some([height, end]) = step.bound {
            path.bound stroke=(step.colour) stroke-dasharray=[dashes] d={ "M" (x) " " (y) "V" (height) "H" (end) } {}
        }
        circle.(class) cx=(x) cy=(y) r="5" stroke=(step.colour) fill=(filled) { title { (step.words) } }
        text x=(x) y=(y - 9.0) text-anchor="middle" { (step.sensors) }
    }
}
