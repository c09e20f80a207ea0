//! The server as strangers and browsers meet it.

mod browsers;
mod changes;
mod files;
mod published;
mod running;
mod strangers;
