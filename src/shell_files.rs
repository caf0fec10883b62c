//! `potamoi completions` and `potamoi man`: files for shells and for `man`, from the program's arguments.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;
use potamoi_base::outputs as files;

use crate::failure::Failure;
use crate::stdout::say;

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// Shell whose completions are printed
    #[arg(value_name = "SHELL", value_enum)]
    shell: Shell,
}

#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// Folder for the manual pages; it is created if missing
    #[arg(value_name = "DIR")]
    dir: PathBuf,
}

/// Prints the completions of a command line.
pub(crate) fn completions(args: &CompletionsArgs, mut cli: Command) {
    let mut text = vec![];
    clap_complete::generate(args.shell, &mut cli, "potamoi", &mut text);
    say!("{}", String::from_utf8_lossy(&text).trim_end());
}

/// Writes a page for the program, and one for each command.
pub(crate) fn man(args: &ManArgs, cli: Command) -> Result<(), Failure> {
    let all = pages(cli)?;
    for (name, page) in &all {
        files::write(&args.dir.join(name), page)?;
    }
    say!(
        "{} pages in {}: man -l {}",
        all.len(),
        args.dir.display(),
        args.dir.join("potamoi.1").display()
    );
    Ok(())
}

/// Names of the pages, and their texts.
pub(crate) fn pages(mut cli: Command) -> Result<Vec<(String, String)>, Failure> {
    cli.build();
    let commands = cli.get_subcommands().filter(|own| own.get_name() != "help");
    let named = |own: &Command| format!("potamoi-{}", own.get_name());
    let commands = commands.map(|own| (named(own), own.clone()));
    let whole = ("potamoi".to_owned(), cli.clone());
    let one = |(name, command): (String, Command)| {
        let mut page = vec![];
        let made = clap_mangen::Man::new(command).render(&mut page);
        made.map_err(|error| Failure::Output(error.to_string()))?;
        Ok((
            format!("{name}.1"),
            String::from_utf8_lossy(&page).into_owned(),
        ))
    };
    std::iter::once(whole).chain(commands).map(one).collect()
}
