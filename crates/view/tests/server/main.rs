//! The server as strangers and browsers meet it.

mod browsers;
mod changes;
mod files;
mod running;
mod strangers;
