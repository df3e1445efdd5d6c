!> The version of gracecg: the same as in fpm.toml, which a test compares. What a file says of its making.
module gracecg_base_version
    implicit none
    private
    public :: file_comments

    !> Of the package, as in fpm.toml
    character(*), parameter, public :: VERSION = '0.2.0'

contains

    !> The comment lines at the top of a file: version and command, and settings.
    pure function file_comments(command, settings) result(comments)
        character(*), intent(in) :: command     !! That made it: 'errors'
        character(*), intent(in) :: settings    !! What it was made with
        character(200) :: comments(2)

        comments(1) = 'gracecg '//VERSION//' '//command
        comments(2) = settings
    end function file_comments
end module gracecg_base_version
