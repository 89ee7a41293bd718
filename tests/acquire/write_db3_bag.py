# Writes messages as a bag of ROS 2 in SQLite, with SQLite itself and rosbag2's tables:
#   python3 write_db3_bag.py MESSAGES OUT.db3 PAGE_SIZE
# MESSAGES: for each its topic, type and data after their lengths in 32 bits, the time in 64 bits before the data.
# Exit code 77: Python has no sqlite3.
import struct
import sys

try:
    import sqlite3
except ImportError:
    sys.exit(77)

messages, output, page_size = sys.argv[1], sys.argv[2], int(sys.argv[3])
with open(messages, "rb") as file:
    content = file.read()
at = 0


def take_bytes():
    global at
    (length,) = struct.unpack_from("<I", content, at)
    at += 4 + length
    return content[at - length : at]


database = sqlite3.connect(output)
database.execute(f"PRAGMA page_size={page_size}")
database.execute(
    "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL)"
)
database.execute(
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
    "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)"
)
database.execute(
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
    "data BLOB NOT NULL)"
)
database.execute("CREATE INDEX timestamp_idx ON messages (timestamp ASC)")
topics = {}
while at < len(content):
    topic, kind = take_bytes().decode(), take_bytes().decode()
    (time,) = struct.unpack_from("<q", content, at)
    at += 8
    data = take_bytes()
    if topic not in topics:
        topics[topic] = len(topics) + 1
        database.execute(
            "INSERT INTO topics VALUES (?, ?, ?, 'cdr', '- history: 3')",
            (topics[topic], topic, kind),
        )
    database.execute(
        "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
        (topics[topic], time, data),
    )
database.commit()
database.close()
