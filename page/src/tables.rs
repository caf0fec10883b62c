//! Tables of the page.

use maud::{Markup, html};

/// A table whose first column names its rows; it scrolls by itself where the page is narrow.
pub(super) fn table(caption: &str, header: &[&str], rows: Vec<Vec<Markup>>) -> Markup {
    html! {
        div class="scroll" role="group" aria-label=(caption) tabindex="0" {
            table {
                caption { (caption) }
                thead { tr { @for own in header { th scope="col" { (own) } } } }
                tbody {
                    @for row in &rows {
                        tr {
                            @for (at, cell) in row.iter().enumerate() {
                                @if at == 0 { th scope="row" { (cell) } } @else { td { (cell) } }
                            }
                        }
                    }
                }
            }
        }
    }
}
