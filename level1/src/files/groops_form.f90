!> Instrument files of GROOPS as text (and, to be read, its matrix files and bare columns with the same numbers): a first line
!> `groops instrument version=N`, type and number of arcs, and for each arc the number of its epochs and their lines: MJD in GPS
!> time, values in SI or, as it takes them from Level-1 files, in their units. An orbit is inertial and has accelerations behind
!> position and velocity, here 0; a quaternion turns SRF into inertial axes as an active rotation, which are the numbers of SCA1B.
!> Source: fileInstrument, fileMatrix, archiveAscii and rotary3d of github.com/groops-devs/groops.
module gracecg_level1_groops_form
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, split_words, parse_integer, parse_real, integer_text, real_text
    use gracecg_files_file, only: output_file_t, text_file_t, read_text_file
    use gracecg_level1_exchange_series, only: exchange_series_t, EXCHANGE_KINDS, ORBIT, make_room, keep_first
    implicit none
    private
    public :: write_groops, read_groops

    character(*), parameter :: VERSION = '20200123'
    integer, parameter :: ACCELERATIONS = 3     ! behind an orbit's velocity
    integer(i8), parameter :: DAY = 86400, NOON = 43200
    integer, parameter :: MJD_2000 = 51544

contains

    !> Writes a series as one arc. Fails for an Earth-fixed orbit, and when the file cannot be written.
    subroutine write_groops(series, path, error)
        type(exchange_series_t), intent(in) :: series
        character(*), intent(in) :: path    !! Of the file
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: line
        character(20) :: part
        integer(i8) :: since
        integer :: i, k

        if (series%kind == ORBIT .and. series%axes /= 'I') then
            call fail(error, path//': an orbit of GROOPS is inertial; take GNI1B, or write GNV1B as an OEM')
            return
        end if
        call file%open(path, error)
        if (allocated(error)) return
        associate (about => EXCHANGE_KINDS(series%kind))
            call file%line('groops instrument version='//VERSION)
            call file%line('# '//trim(about%name))
            call file%line(integer_text(about%code)//' 1 # instrument type, number of arcs')
            call file%line('# Time [MJD], GPS; '//trim(about%fields)//' as in Level-1 files')
        end associate
        call file%line(integer_text(size(series%seconds))//' # number of epochs of 1. arc')
        do i = 1, size(series%seconds)
            since = series%seconds(i) + NOON
            write (part, '(f20.18)') (real(modulo(since, DAY), dp) + series%fraction(i))/real(DAY, dp)
            line = integer_text(MJD_2000 + (since - modulo(since, DAY))/DAY)//part(2:)
            do k = 1, size(series%values, 1)
                line = line//' '//real_text(series%values(k, i))
            end do
            if (series%kind == ORBIT) line = line//' 0 0 0'
            call file%line(line)
        end do
        call file%commit(error)
    end subroutine write_groops

    !> Reads a series; arcs follow each other. Fails at the first line that is not as it has to be, and when the type is none of
    !> EXCHANGE_KINDS, or, of a matrix, another one than is wanted.
    subroutine read_groops(path, wanted, series, error)
        character(*), intent(in) :: path    !! Of the file
        integer, intent(in) :: wanted       !! Kind that a matrix file, which does not say its own, holds
        type(exchange_series_t), intent(out) :: series
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        type(string_t), allocatable :: words(:)
        integer :: at, type, arcs, arc, epochs, i, n

        allocate (series%remarks(0))
        series%kind = wanted
        call read_text_file(path, file, error)
        if (allocated(error)) return
        at = 0
        n = 0
        call next_words(file, at, words)
        if (size(words) > 1 .and. index(file%line(1), 'instrument') > 0) then
            call next_words(file, at, words)
            call take_integers(file, at, words, 'instrument type and number of arcs', type, arcs, error)
            if (allocated(error)) return
            series%kind = findloc(EXCHANGE_KINDS%code, type, 1)
            if (series%kind == 0) call file%fail_at(at, 'instrument type '//integer_text(type)//' has no Level-1 product '// &
                                                    'here; -6, -7, -8, -16, -17 and -18 have', error)
            if (allocated(error)) return
            call make_room(series, file%line_count())
            do arc = 1, arcs
                call next_words(file, at, words)
                call take_integers(file, at, words, 'number of epochs', epochs, error=error)
                do i = 1, epochs
                    if (allocated(error)) return
                    call next_words(file, at, words)
                    n = n + 1
                    call take_epoch(file, at, words, series, n, error)
                end do
                if (allocated(error)) return
            end do
        else
            call make_room(series, file%line_count())
            do while (size(words) > 0)
                if (scan(words(1)%text(1:1), '0123456789') > 0) then
                    n = n + 1
                    call take_epoch(file, at, words, series, n, error)
                    if (allocated(error)) return
                end if
                call next_words(file, at, words)
            end do
        end if
        call keep_first(series, n, path, error)
    end subroutine read_groops

    !> The words of the next line that has any, without comments; none at the end.
    subroutine next_words(file, at, words)
        type(text_file_t), intent(in) :: file
        integer, intent(inout) :: at        !! Number of the line
        type(string_t), allocatable, intent(out) :: words(:)

        integer :: comment

        allocate (words(0))
        do while (at < file%line_count() .and. size(words) == 0)
            at = at + 1
            comment = index(file%line(at)//'#', '#')
            associate (line => file%text(file%first(at):file%last(at)))
                words = split_words(line(:min(len(line), comment - 1)))
            end associate
        end do
    end subroutine next_words

    !> One or two whole numbers that a line begins with.
    subroutine take_integers(file, at, words, what, first, second, error)
        type(text_file_t), intent(in) :: file
        integer, intent(in) :: at
        type(string_t), intent(in) :: words(:)
        character(*), intent(in) :: what
        integer, intent(out) :: first
        integer, intent(out), optional :: second
        type(error_t), allocatable, intent(out) :: error

        logical :: ok

        first = 0
        ok = size(words) == merge(2, 1, present(second))
        if (ok) call parse_integer(words(1)%text, first, ok)
        if (ok .and. present(second)) call parse_integer(words(2)%text, second, ok)
        if (ok .and. .not. present(second)) ok = first >= 0
        if (.not. ok) call file%fail_at(at, 'expected: '//what, error)
    end subroutine take_integers

    !> A sample: MJD and values, in whole microseconds.
    subroutine take_epoch(file, at, words, series, number, error)
        type(text_file_t), intent(in) :: file
        integer, intent(in) :: at
        type(string_t), intent(in) :: words(:)
        type(exchange_series_t), intent(inout) :: series
        integer, intent(in) :: number       !! Of the sample
        type(error_t), allocatable, intent(out) :: error

        integer(i8) :: microseconds
        real(dp) :: part, value
        integer :: columns, k, point, mjd
        logical :: ok

        columns = EXCHANGE_KINDS(series%kind)%columns
        ok = size(words) == 1 + columns .or. (series%kind == ORBIT .and. size(words) == 1 + columns + ACCELERATIONS)
        if (.not. ok) then
            call file%fail_at(at, 'expected: MJD and '//integer_text(columns)//' numbers of '// &
                              trim(EXCHANGE_KINDS(series%kind)%name)//', here are '//integer_text(size(words)), error)
            return
        end if
        associate (word => words(1)%text)
            call parse_real(word, part, ok)
            if (ok) ok = part > MJD_2000 .and. part < 2*MJD_2000
            if (ok) mjd = floor(part)
            point = index(word, '.')
            if (ok .and. point > 1 .and. verify(word, '0123456789.') == 0) then     ! so that no digit of the day is lost
                call parse_real('0'//word(point:)//'0', part, ok)
            else
                part = part - floor(part)
            end if
        end associate
        if (.not. ok) then
            call file%fail_at(at, '"'//words(1)%text//'" is no MJD since 2000', error)
            return
        end if
        microseconds = nint(part*real(DAY, dp)*1e6_dp, i8)
        series%seconds(number) = (mjd - MJD_2000)*DAY - NOON + microseconds/1000000
        series%fraction(number) = real(modulo(microseconds, 1000000_i8), dp)/1e6_dp
        do k = 2, size(words)
            call parse_real(words(k)%text, value, ok)
            if (.not. ok) then
                call file%fail_at(at, 'column '//integer_text(k)//', "'//words(k)%text//'", is no number', error)
                return
            end if
            if (k <= 1 + columns) series%values(k - 1, number) = value
        end do
    end subroutine take_epoch
end module gracecg_level1_groops_form
