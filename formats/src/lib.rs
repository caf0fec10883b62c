//! Fixed-point formats, configuration and data layouts that generator and oracle share.
