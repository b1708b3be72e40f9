#ifndef PM_BASE_STATUS_H
#define PM_BASE_STATUS_H

/* What a fallible call returns. Anything but PM_OK leaves the outputs untouched. */
typedef enum pm_status {
    PM_OK = 0,
    PM_E_MEMORY,      /* an allocation failed */
    PM_E_IO,          /* the operating system refused a read or a write */
    PM_E_SYNTAX,      /* text that does not parse */
    PM_E_RANGE,       /* a value outside its range, or not finite */
    PM_E_UNSUPPORTED, /* understood, but not offered */
    PM_E_MISSING,     /* a name that is not there */
    PM_E_MISMATCH,    /* parts that do not belong together, e.g. a map of another scene */
    PM_E_CORRUPT,     /* a checksum or a length that does not agree */
    PM_E_LIMIT,       /* larger than a stated limit */
    PM_E_CANCELLED,   /* the caller asked to stop */
    PM_E_UNREACHABLE, /* no server answers */
} pm_status;

#define PM_MUST_USE __attribute__((warn_unused_result))

#endif
