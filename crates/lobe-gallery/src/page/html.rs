//! The page of the demo: sections of figures, tables and text, as one HTML file beside its pictures.

use std::fmt::Write as _;

/// An HTML page under construction. Text given to it is plain: it is escaped here.
#[derive(Default)]
pub(crate) struct Page {
    title: String,
    body: String,
}

const STYLE: &str = "\
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 74rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2 { line-height: 1.2; }
h2 { margin-top: 3rem; }
p { max-width: 46rem; }
figure { display: inline-block; margin: 0 1rem 1rem 0; vertical-align: top; }
figcaption { font-size: .85rem; opacity: .8; max-width: 32rem; }
img { max-width: 100%; height: auto; border-radius: 4px; }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .8rem; text-align: right; border-bottom: 1px solid #8884; }
th:first-child, td:first-child { text-align: left; }
code, pre { font: .9em ui-monospace, monospace; }
pre { background: #8882; padding: .6rem 1rem; border-radius: 4px; overflow-x: auto; }
";

/// Whether more will follow on a page.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum State {
    /// It says so, and the browser looks for more every few seconds.
    Growing,
    Complete,
}

/// Stands in the head of a page that grows.
const LOAD_AGAIN: &str = "<meta http-equiv=\"refresh\" content=\"5\">\n";

/// Stands at its end.
const MORE: &str =
    "<p>More is being made. If nothing has come for minutes, the program was stopped: run it again.</p>\n";

impl Page {
    /// The title, which stands above all and in the browser's.
    pub(crate) fn title(&mut self, title: &str) {
        self.title = escape(title);
        self.tag("h1", title);
    }

    pub(crate) fn section(&mut self, title: &str) {
        self.tag("h2", title);
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.tag("p", text);
    }

    /// A command that the reader can type.
    pub(crate) fn command(&mut self, command: &str) {
        self.tag("pre", command);
    }

    /// A picture in a file beside the page, `width` wide on the page whatever its own pixels.
    pub(crate) fn figure(&mut self, file: &str, width: usize, caption: &str) {
        let (file, caption) = (escape(file), escape(caption));
        self.line(&format!(
            "<figure><img src=\"{file}\" width=\"{width}\" alt=\"{caption}\"><figcaption>{caption}</figcaption></figure>"
        ));
    }

    pub(crate) fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        let row = |cell: &str, cells: &mut dyn Iterator<Item = &str>| {
            cells.fold(String::new(), |mut row, text| {
                let _infallible = write!(row, "<{cell}>{}</{cell}>", escape(text));
                row
            })
        };
        self.line("<table>");
        self.line(&format!("<tr>{}</tr>", row("th", &mut head.iter().copied())));
        for cells in rows {
            self.line(&format!("<tr>{}</tr>", row("td", &mut cells.iter().map(String::as_str))));
        }
        self.line("</table>");
    }

    pub(crate) fn html(&self, state: State) -> String {
        let Self { title, body } = self;
        let (load_again, more) = if state == State::Growing { (LOAD_AGAIN, MORE) } else { ("", "") };
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n{load_again}\
             <meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n\
             <style>\n{STYLE}</style>\n</head>\n<body>\n{body}{more}</body>\n</html>\n"
        )
    }

    fn tag(&mut self, tag: &str, text: &str) {
        let text = escape(text);
        self.line(&format!("<{tag}>{text}</{tag}>"));
    }

    fn line(&mut self, html: &str) {
        self.body.push_str(html);
        self.body.push('\n');
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_everywhere() {
        let mut page = Page::default();
        page.title("<t>");
        page.section("a < b & \"c\"");
        page.figure("x\".png", 10, "1 > 0");
        page.table(&["<h>"], &[vec!["<d>".into()]]);
        let html = page.html(State::Complete);
        for expected in
            ["a &lt; b &amp; &quot;c&quot;", "x&quot;.png", "1 &gt; 0", "&lt;h&gt;", "&lt;d&gt;", "&lt;t&gt;"]
        {
            assert!(html.contains(expected), "{expected} is missing from {html}");
        }
    }
}
