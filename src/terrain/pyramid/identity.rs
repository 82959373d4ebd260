//! Which ground a file is.

use super::Pyramid;
use super::file::Header;

impl Pyramid {
    /// Tells contents apart: the checksum of the head, which has those of all that follows.
    pub fn checksum(&self) -> u32 {
        let header: Header = bytemuck::pod_read_unaligned(&self.map[..size_of::<Header>()]);
        header.checksum
    }
}
