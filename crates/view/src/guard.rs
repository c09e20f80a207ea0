//! Who may speak to the server.
//!
//! On loopback: whoever names it by a loopback name. A page from elsewhere cannot, even where its own
//! name leads to this machine (DNS rebinding): its requests carry that name as Host, and their Origin.
//! On another address (`--bind`): whoever brings the token that was printed. It is good once and buys a
//! cookie; then the next one is printed.

use std::{
    net::{IpAddr, SocketAddr},
    sync::{Mutex, PoisonError},
};

use axum::http::{HeaderMap, header};

use crate::{ViewError, names};

/// Random bytes of a secret.
const SECRET_BYTES: usize = 16;

/// The rules of one server.
pub struct Guard {
    address: SocketAddr,
    secrets: Option<Mutex<Secrets>>,
}

struct Secrets {
    token: String,
    /// What cookies hold.
    session: String,
}

/// Random letters that nobody guesses.
///
/// # Errors
/// If the system has no randomness.
pub fn secret() -> Result<String, ViewError> {
    let mut bytes = [0; SECRET_BYTES];
    getrandom::fill(&mut bytes).map_err(|error| ViewError::Io(std::io::Error::other(error.to_string())))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

impl Guard {
    /// Of a server at `address`; with tokens where that is not loopback.
    ///
    /// # Errors
    /// If the system has no randomness.
    pub fn new(address: SocketAddr) -> Result<Self, ViewError> {
        let secrets = || Ok::<_, ViewError>(Mutex::new(Secrets { token: secret()?, session: secret()? }));
        let secrets = (!address.ip().is_loopback()).then(secrets).transpose()?;
        Ok(Self { address, secrets })
    }

    /// Where browsers find the page, token included: one place or several, the likeliest first.
    pub fn urls(&self) -> Vec<String> {
        let token = self.secrets.as_ref().map(|secrets| lock(secrets).token.clone());
        let query = token.map_or(String::new(), |token| format!("?token={token}"));
        let hosts = names::of(self.address.ip());
        hosts.iter().map(|host| format!("http://{host}:{}/{query}", self.address.port())).collect()
    }

    /// Whether a request names this server, and comes from its own page or from no page at all.
    pub fn names_this_server(&self, headers: &HeaderMap) -> bool {
        let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or(""));
        let Some(host) = text(header::HOST) else { return false };
        if headers.get_all(header::HOST).iter().count() != 1 || !self.is_own_name(host) {
            return false;
        }
        text(header::ORIGIN).is_none_or(|origin| origin.strip_prefix("http://") == Some(host))
    }

    /// A name in front of any port: tunnels have ports of their own.
    fn is_own_name(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.contains(']') => (name, port),
            _ => (host, "80"),
        };
        if port.parse::<u16>().is_err() {
            return false;
        }
        if name.eq_ignore_ascii_case("localhost") {
            return true;
        }
        let bare = name.trim_start_matches('[').trim_end_matches(']');
        let Ok(ip) = bare.parse::<IpAddr>() else {
            // With tokens the name does not matter: what it leads to is guarded by the cookie.
            return self.secrets.is_some();
        };
        ip.is_loopback() || self.secrets.is_some()
    }

    /// Whether a request carries the cookie, or needs none.
    pub fn is_admitted(&self, headers: &HeaderMap) -> bool {
        let Some(secrets) = &self.secrets else { return true };
        let wanted = format!("{}={}", self.cookie_name(), lock(secrets).session);
        let cookies = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
        cookies.flat_map(|value| value.split(';')).any(|cookie| same(cookie.trim(), &wanted))
    }

    /// Takes the token that a query brings and gives a cookie for it. The token is void from then on.
    ///
    /// # Errors
    /// If the system has no randomness.
    pub fn redeem(&self, query: &str) -> Result<Option<String>, ViewError> {
        let Some(secrets) = &self.secrets else { return Ok(None) };
        let Some(given) = query.split('&').find_map(|pair| pair.strip_prefix("token=")) else {
            return Ok(None);
        };
        let mut secrets = lock(secrets);
        if !same(given, &secrets.token) {
            return Ok(None);
        }
        secrets.token = secret()?;
        let (name, session) = (self.cookie_name(), &secrets.session);
        Ok(Some(format!("{name}={session}; Path=/; HttpOnly; SameSite=Strict")))
    }

    /// Cookies do not tell ports apart: names do.
    fn cookie_name(&self) -> String {
        format!("midway-{}", self.address.port())
    }
}

fn lock(secrets: &Mutex<Secrets>) -> std::sync::MutexGuard<'_, Secrets> {
    secrets.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Compares all of both, so that time tells nothing.
fn same(one: &str, other: &str) -> bool {
    one.len() == other.len() && one.bytes().zip(other.bytes()).fold(0, |all, (a, b)| all | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
        pairs
            .iter()
            .map(|(name, value)| (name.parse().unwrap(), value.parse().unwrap()))
            .collect::<HeaderMap>()
    }

    fn guard(address: &str) -> Guard {
        Guard::new(address.parse().unwrap()).unwrap()
    }

    fn admits(guard: &Guard, host: &str, origin: Option<&str>) -> bool {
        let mut all = vec![("host", host)];
        all.extend(origin.map(|origin| ("origin", origin)));
        guard.names_this_server(&headers(&all))
    }

    #[test]
    fn loopback_names_pass_through_any_tunnel() {
        let guard = guard("127.0.0.1:8080");
        for host in
            ["127.0.0.1:8080", "localhost:9000", "LOCALHOST:1", "[::1]:8080", "127.0.0.1", "localhost"]
        {
            assert!(admits(&guard, host, None), "{host}");
            assert!(admits(&guard, host, Some(&format!("http://{host}"))), "{host}");
        }
    }

    #[test]
    fn other_names_and_other_pages_do_not() {
        let guard = guard("127.0.0.1:8080");
        for host in [
            "evil.example:8080",
            "localhost.evil.example",
            "10.0.0.1:8080",
            "",
            "localhost:x",
            "[::1",
            "localhost:80:80",
        ] {
            assert!(!admits(&guard, host, None), "{host}");
        }
        for origin in [
            "http://evil.example",
            "http://localhost:9999",
            "null",
            "https://localhost:8080",
            "http://localhost:8080/",
        ] {
            assert!(!admits(&guard, "localhost:8080", Some(origin)), "{origin}");
        }
        assert!(!guard.names_this_server(&HeaderMap::new()));
    }

    #[test]
    fn a_token_is_good_once_and_buys_a_cookie() {
        let guard = guard("10.1.2.3:8080");
        assert!(admits(&guard, "gpu-server:8080", Some("http://gpu-server:8080")));
        assert!(!admits(&guard, "gpu-server:8080", Some("http://evil.example")));
        assert!(!guard.is_admitted(&headers(&[("host", "10.1.2.3:8080")])));
        let urls = guard.urls();
        let query = urls[0].split_once('?').unwrap().1;
        assert!(guard.redeem("token=0").unwrap().is_none() && guard.redeem("").unwrap().is_none());
        let cookie = guard.redeem(query).unwrap().expect("is good");
        assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"));
        assert!(guard.redeem(query).unwrap().is_none(), "twice");
        assert_ne!(guard.urls(), urls);
        let pair = cookie.split(';').next().unwrap();
        assert!(guard.is_admitted(&headers(&[("cookie", &format!("a=b; {pair}"))])));
        assert!(!guard.is_admitted(&headers(&[("cookie", "midway-8080=0")])));
    }
}
