!> The version of gracecg: the same as in fpm.toml, which a test compares.
module gracecg_base_version
    implicit none
    private

    !> Of the package, as in fpm.toml
    character(*), parameter, public :: VERSION = '0.1.0'
end module gracecg_base_version
