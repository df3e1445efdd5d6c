!> Writes files in namelist syntax that `gracecg_files_namelist` reads, as Fortran itself does.
module gracecg_files_namelist_writer
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context, fail
    use gracecg_files_file, only: output_file_t
    use gracecg_base_text, only: real_field, LONGEST_REAL, integer_text
    implicit none
    private
    public :: namelist_writer_t

    type :: namelist_writer_t
        !! Writes groups and keys to a text, which can be saved as a file or shown
        private
        character(:), allocatable :: content    !! What was written, and room behind it
        integer :: length = 0                   !! Characters of it that were written
        type(error_t), allocatable :: failure   !! The first thing that cannot be written
    contains
        procedure :: comment => write_comment       !! Writes a line of comment
        procedure :: group => write_group           !! Begins a group
        generic :: entry => write_real, write_reals, write_integer, write_logical, write_text
        !! Writes a key with its value or values
        procedure :: end_group => write_end_group   !! Ends a group
        procedure :: to_text                        !! What was written so far
        procedure :: save => save_namelist          !! Saves it as a file
        ! The specific procedures of a generic stay public: when they are private, gfortran 12
        ! refuses to read the module files of two users of this type ("mismatch in components")
        procedure :: write_real     !! One real number
        procedure :: write_reals    !! Several real numbers
        procedure :: write_integer  !! One integer
        procedure :: write_logical  !! One logical
        procedure :: write_text     !! One text
    end type namelist_writer_t

    character(*), parameter :: LF = achar(10), CR = achar(13)

contains

    !> A line of comment.
    subroutine write_comment(self, text)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Without the exclamation mark

        call put(self, trim('! '//text))
    end subroutine write_comment

    !> Begins a group.
    subroutine write_group(self, name)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: name    !! Of the group

        call put(self, '&'//name)
    end subroutine write_group

    subroutine write_end_group(self)
        class(namelist_writer_t), intent(inout) :: self

        call put(self, '/')
    end subroutine write_end_group

    subroutine write_real(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key                 !! Its name
        real(dp), intent(in) :: value                   !! Finite
        character(*), intent(in), optional :: comment   !! Behind the value: unit and meaning

        call write_reals(self, key, [value], comment)
    end subroutine write_real

    subroutine write_reals(self, key, values, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key                 !! Its name
        real(dp), intent(in) :: values(:)               !! Finite
        character(*), intent(in), optional :: comment   !! Behind the values: unit and meaning

        character((LONGEST_REAL + 2)*size(values)) :: text
        character(LONGEST_REAL) :: number
        integer :: i, n

        if (.not. all(ieee_is_finite(values)) .or. size(values) == 0) &
            call refuse(self, 'key "'//key//'": its value is not a finite number')
        n = 0
        do i = 1, size(values)
            number = real_field(values(i))
            text(n + 1:) = trim(number)//', '
            n = n + len_trim(number) + 2
        end do
        call put_entry(self, key, text(:n - 2), comment)
    end subroutine write_reals

    subroutine write_integer(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key                 !! Its name
        integer, intent(in) :: value                    !! As it shall stand
        character(*), intent(in), optional :: comment   !! Behind the value: meaning

        call put_entry(self, key, integer_text(value), comment)
    end subroutine write_integer

    subroutine write_logical(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key                 !! Its name
        logical, intent(in) :: value                    !! As it shall stand
        character(*), intent(in), optional :: comment   !! Behind the value: meaning

        call put_entry(self, key, trim(merge('.true. ', '.false.', value)), comment)
    end subroutine write_logical

    subroutine write_text(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, value          !! Name and text, of one line
        character(*), intent(in), optional :: comment   !! Behind the value: meaning

        character(:), allocatable :: text
        integer :: i

        if (scan(value, LF//CR) > 0) &
            call refuse(self, 'key "'//key//'": a text must stand in one line')
        text = ''
        do i = 1, len(value)
            text = text//value(i:i)
            if (value(i:i) == '''') text = text//''''
        end do
        call put_entry(self, key, ''''//text//'''', comment)
    end subroutine write_text

    subroutine put_entry(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, value
        character(*), intent(in), optional :: comment

        if (present(comment)) then
            call put(self, '    '//key//' = '//value//'  ! '//trim(comment))
        else
            call put(self, '    '//key//' = '//value)
        end if
    end subroutine put_entry

    subroutine put(self, line)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: line

        character(:), allocatable :: roomier
        integer :: from, to

        from = self%length + merge(1, 0, self%length > 0)
        to = from + len(line)
        if (.not. allocated(self%content)) allocate (character(to) :: self%content)
        if (to > len(self%content)) then        ! twice as much: each character is moved once or twice in all
            allocate (character(2*to) :: roomier)
            roomier(:self%length) = self%content(:self%length)
            call move_alloc(roomier, self%content)
        end if
        if (from > 0) self%content(from:from) = LF
        self%content(from + 1:to) = line
        self%length = to
    end subroutine put

    !> Notes the first thing that cannot be written.
    subroutine refuse(self, message)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: message

        if (.not. allocated(self%failure)) call fail(self%failure, message)
    end subroutine refuse

    !> What was written so far, without a line end at the end. Fails when something could not be
    !> written: a number that is not finite, a text of several lines.
    subroutine to_text(self, text, error)
        class(namelist_writer_t), intent(in) :: self
        character(:), allocatable, intent(out) :: text  !! Lines separated by line feeds
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) error = self%failure
        text = ''
        if (allocated(self%content)) text = self%content(:self%length)
    end subroutine to_text

    !> Saves what was written; fails as `to_text` does, or when the file cannot be written.
    subroutine save_namelist(self, path, error)
        class(namelist_writer_t), intent(in) :: self
        character(*), intent(in) :: path    !! Of the file to write; an existing one is replaced
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: text

        call self%to_text(text, error)
        call add_context(error, trim(path))
        if (allocated(error)) return
        call file%open(path, error)
        if (allocated(error)) return
        call file%line(text)
        call file%commit(error)
    end subroutine save_namelist
end module gracecg_files_namelist_writer
