//! By what names this machine is found by browsers.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

use sysinfo::System;

/// Addresses that are nobody's (RFC 5737, RFC 3849): what is sent to them would leave by the usual way.
const ELSEWHERE: [IpAddr; 2] =
    [IpAddr::V4(Ipv4Addr::new(192, 0, 2, 1)), IpAddr::V6(Ipv6Addr::new(0x2001, 0xdb8, 0, 0, 0, 0, 0, 1))];

/// Hosts for the address bar, of a server that listens at `ip`; at least one. Where it listens at all
/// addresses: the one by which this machine reaches others, then its name, which others may know.
pub fn of(ip: IpAddr) -> Vec<String> {
    if !ip.is_unspecified() {
        return vec![bracketed(ip)];
    }
    let heard = |to: &&IpAddr| to.is_ipv4() || ip.is_ipv6();
    let own = ELSEWHERE.iter().filter(heard).filter_map(|to| towards(*to)).map(bracketed);
    let mut hosts: Vec<String> = own.chain(System::host_name()).collect();
    if hosts.is_empty() {
        hosts.push("localhost".to_owned());
    }
    hosts
}

/// This machine's address on the way to another. Nothing is sent.
fn towards(other: IpAddr) -> Option<IpAddr> {
    let any = if other.is_ipv4() { IpAddr::V4(Ipv4Addr::UNSPECIFIED) } else { Ipv6Addr::UNSPECIFIED.into() };
    let socket = UdpSocket::bind(SocketAddr::new(any, 0)).ok()?;
    socket.connect(SocketAddr::new(other, 9)).ok()?;
    socket.local_addr().ok().map(|own| own.ip()).filter(|ip| !ip.is_unspecified())
}

/// As it is written in front of a port.
fn bracketed(ip: IpAddr) -> String {
    match ip {
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_its_own_name() {
        assert_eq!(of(Ipv4Addr::LOCALHOST.into()), ["127.0.0.1"]);
        assert_eq!(of(Ipv6Addr::LOCALHOST.into()), ["[::1]"]);
    }

    #[test]
    fn all_addresses_are_no_name() {
        for any in [IpAddr::V4(Ipv4Addr::UNSPECIFIED), Ipv6Addr::UNSPECIFIED.into()] {
            let hosts = of(any);
            assert!(!hosts.is_empty());
            for host in hosts {
                let bare = host.trim_matches(['[', ']']);
                assert!(
                    !bare.is_empty() && bare.parse::<IpAddr>().is_ok_and(|ip| !ip.is_unspecified())
                        || bare.parse::<IpAddr>().is_err(),
                    "{host}"
                );
            }
        }
    }
}
