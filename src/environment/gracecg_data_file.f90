!> Text tables of a user: lines of fields between blanks, `#` begins a comment.
module gracecg_data_file
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t, fail, fail_in_file
    implicit none
    private
    public :: data_line_t, read_data_lines, split_fields, real_of_field

    type :: data_line_t
        !! A line that holds data
        character(:), allocatable :: text   !! Without comment
        integer :: number = 0               !! In the file, counted from 1
    end type data_line_t

contains

    !> The lines of a file without comments and blank lines. Fails when the file cannot be read or
    !> holds no data.
    subroutine read_data_lines(file, lines, error)
        character(*), intent(in) :: file
        type(data_line_t), allocatable, intent(out) :: lines(:)
        type(error_t), allocatable, intent(out) :: error

        type(data_line_t), allocatable :: larger(:)
        character(:), allocatable :: text
        character(256) :: reason
        integer :: unit, status, line_number, n

        open (newunit=unit, file=file, status='old', action='read', iostat=status, iomsg=reason)
        if (status /= 0) then
            call fail(error, 'cannot read "'//file//'": '//trim(reason))
            return
        end if
        allocate (lines(64))
        n = 0
        line_number = 0
        do
            call read_line(unit, text, status)
            if (status /= 0) exit
            line_number = line_number + 1
            text = without_comment(text)
            if (text == '') cycle
            if (n == size(lines)) then
                allocate (larger(2*n))
                larger(:n) = lines
                call move_alloc(larger, lines)
            end if
            n = n + 1
            lines(n) = data_line_t(text, line_number)
        end do
        close (unit)
        if (.not. is_iostat_end(status)) then
            call fail_in_file(error, file, line_number + 1, 'cannot be read as text')
        else if (n == 0) then
            call fail(error, file//': holds no data (only blank lines and comments)')
        end if
        lines = lines(:n)
    end subroutine read_data_lines

    !> One line of any length.
    subroutine read_line(unit, text, status)
        integer, intent(in) :: unit
        character(:), allocatable, intent(out) :: text
        integer, intent(out) :: status      !! 0, or an I/O status (end of file)

        character(256) :: buffer
        integer :: length

        text = ''
        do
            read (unit, '(a)', advance='no', iostat=status, size=length) buffer
            if (status == 0) then
                text = text//buffer
            else
                if (is_iostat_eor(status)) then
                    text = text//buffer(:length)
                    status = 0
                end if
                return
            end if
        end do
    end subroutine read_line

    !> A line up to its comment; tabs and carriage returns become blanks.
    pure function without_comment(line) result(text)
        character(*), intent(in) :: line
        character(:), allocatable :: text

        integer :: i

        text = line
        i = index(text, '#')
        if (i > 0) text = text(:i - 1)
        do i = 1, len(text)
            if (text(i:i) == achar(9) .or. text(i:i) == achar(13)) text(i:i) = ' '
        end do
        text = trim(text)
    end function without_comment

    !> The words of a line, in order.
    pure subroutine split_fields(line, fields)
        character(*), intent(in) :: line
        character(len(line)), allocatable, intent(out) :: fields(:)

        integer :: i, first, pass, n

        do pass = 1, 2      ! count, then cut
            n = 0
            first = 0
            do i = 1, len(line) + 1
                if (is_blank(i)) then
                    if (first > 0) then
                        n = n + 1
                        if (pass == 2) fields(n) = line(first:i - 1)
                    end if
                    first = 0
                else if (first == 0) then
                    first = i
                end if
            end do
            if (pass == 1) allocate (fields(n))
        end do

    contains

        pure logical function is_blank(position)
            integer, intent(in) :: position

            is_blank = .true.
            if (position <= len(line)) is_blank = line(position:position) == ' '
        end function is_blank
    end subroutine split_fields

    !> The number a field holds; not valid when it is none (NaN and Inf are none).
    subroutine real_of_field(field, value, valid)
        character(*), intent(in) :: field
        real(dp), intent(out) :: value
        logical, intent(out) :: valid

        integer :: status

        value = 0
        valid = verify(trim(field), '+-.0123456789eEdD') == 0 .and. scan(field, '0123456789') > 0
        if (.not. valid) return
        read (field, *, iostat=status) value
        valid = status == 0 .and. abs(value) <= huge(value)
    end subroutine real_of_field
end module gracecg_data_file
