//! The fenced blocks of a Markdown document.

/// A block between fences.
pub(crate) struct Block {
    /// The first word behind the fence.
    pub(crate) language: String,
    /// Whether it is run here. Not where the other word there is `not-run`, as it needs what a test has not, or `wheel`:
    /// tests/python/test_guide.py runs it with the Python package.
    pub(crate) is_run: bool,
    pub(crate) text: String,
    /// Document and line, for messages.
    pub(crate) place: String,
}

/// All blocks of a document, which is called `name`.
#[track_caller]
pub(crate) fn blocks(name: &str, document: &str) -> Vec<Block> {
    let (mut blocks, mut open): (Vec<Block>, Option<(Block, usize)>) = (Vec::new(), None);
    for (number, line) in document.lines().enumerate() {
        let bare = line.trim_start();
        match (&mut open, bare.strip_prefix("```")) {
            (Some(_), Some(_)) => blocks.push(open.take().unwrap().0),
            (Some((block, indent)), None) => {
                block.text += line.get(*indent..).unwrap_or("");
                block.text += "\n";
            }
            (None, Some(info)) => {
                let place = format!("{name}:{}", number + 1);
                let words: Vec<&str> = info.split_whitespace().collect();
                let is_run = match words[..] {
                    [_] => true,
                    [_, "not-run"] | ["python", "wheel"] => false,
                    _ => panic!("{place}: ```{info}: must be a language, or a language and not-run or wheel"),
                };
                let language = words[0].to_string();
                let block = Block { language, is_run, text: String::new(), place };
                open = Some((block, line.len() - bare.len()));
            }
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "{name}: a block has no end");
    blocks
}

/// The lines outside of blocks.
pub(crate) fn prose(text: &str) -> Vec<&str> {
    let mut is_block = false;
    let is_prose = |line: &&str| {
        let fence = line.trim_start().starts_with("```");
        is_block ^= fence;
        !is_block && !fence
    };
    text.lines().filter(is_prose).collect()
}
