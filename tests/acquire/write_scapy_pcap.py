"""Writes FILE, a .pcap or .pcapng of five UDP datagrams, the larger ones in fragments, some with a VLAN tag.

    write_scapy_pcap.py FILE

Exit code 77: scapy is not installed (Debian package python3-scapy).
"""

import sys

try:
    from scapy.layers.inet import IP, UDP, fragment
    from scapy.layers.l2 import ARP, Dot1Q, Ether
    from scapy.packet import Raw
    from scapy.utils import PcapNgWriter, PcapWriter
except ImportError:
    sys.exit(77)


def main(path):
    writer = PcapNgWriter(path) if path.endswith(".pcapng") else PcapWriter(path, nano=True)
    frames = [Ether() / ARP()]  # no UDP
    frames[0].time = 1_700_000_000
    for i in range(5):
        payload = bytes(k * 7 % 251 for k in range(100 + 3000 * i))
        ip = IP(src="10.0.0.1", dst="10.0.0.2", id=i + 1) / UDP(sport=1, dport=7000 + i) / Raw(payload)
        for part in fragment(ip, fragsize=1480):
            frame = Ether() / Dot1Q(vlan=5) / part if i % 2 else Ether() / part
            frame.time = 1_700_000_000.25 + i
            frames.append(frame)
    for frame in frames:
        writer.write(frame)
    writer.close()


if __name__ == "__main__":
    main(sys.argv[1])
