//! `drape lab`.

use super::refusal;
use crate::cli::output::print;
use drape_lab::Server;
use drape_report::tell;
use std::process::{Command, Stdio};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Port of 127.0.0.1 to listen on; 0 chooses a free one
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
    /// Print the address and do not open a browser
    #[arg(long)]
    no_open: bool,
    /// Start with the set-up of a link, which is its part after #
    #[arg(long, value_name = "TEXT")]
    setup: Option<String>,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let refuse = |error: std::io::Error| {
        let expected = format!("a port that is free ({error}); 0 takes any free one");
        refusal("--port", arguments.port, expected)
    };
    let server = Server::bind(arguments.port).map_err(refuse)?;
    let mut address = server.address();
    if let Some(setup) = &arguments.setup {
        address += &format!("#{}", setup.trim_start_matches('#'));
    }
    print(&format!("{address}\n"))?;
    tell!("drape: the lab runs at this address until you press Ctrl+C");
    if !arguments.no_open
        && let Err(error) = open(&address)
    {
        tell!("drape: no browser could be opened ({error}): open the address yourself");
    }
    server.serve(std::future::pending())?;
    Ok(())
}

/// Opens an address with the program that the system has for it.
fn open(address: &str) -> std::io::Result<()> {
    let (program, first): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(first).arg(address).stdin(Stdio::null()).stdout(Stdio::null());
    command.stderr(Stdio::null()).spawn().map(drop)
}
