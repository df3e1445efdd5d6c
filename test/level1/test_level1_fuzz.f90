!> Level-1 files with anything wrong: the reader never crashes or hangs, and what it reads is what stands there.
!>
!> Files are changed at random: bytes, digits, words, pieces left out, doubled, cut off. Then the reader either says
!> what is wrong, or its numbers are those of the changed file by another way: word by word with the run-time
!> library (text), byte by byte by writing them again (binary).
module test_level1_fuzz
    use vocabulary
    use gracecg_base_text, only: parse_real, lower_case
    use gracecg_files_file, only: file_exists, text_file_t, read_text_file
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_products, only: level1_layout_t, level1_layout, KIND_F4, KIND_F8, KIND_LETTER, &
        KIND_FLAG8, KIND_FLAG32
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_summary, only: level1_summary_t, summarise_level1
    use gracecg_level1_writer, only: level1_writer_t
    implicit none
    private
    public :: collect_level1_fuzz

    integer, parameter :: EXECUTIONS = 10000, MOST_SEEDS = 20
    character(1), parameter :: LF = achar(10)
    character(*), parameter :: SAMPLES = '..'//'/shared/level1/samples/', DAY = '_2023-06-01_C_04.txt'

    type :: seed_t
        character(:), allocatable :: name       !! Of the file, which tells the product
        character(:), allocatable :: content
        integer :: records_begin = 1            !! Behind the header
    end type seed_t

contains

    subroutine collect_level1_fuzz(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [new_unittest('changed-files', test_changed)]
    end subroutine collect_level1_fuzz

    subroutine test_changed(error)
        type(error_type), allocatable, intent(out) :: error
        type(seed_t) :: seeds(MOST_SEEDS)
        type(random_stream_t) :: stream
        character(:), allocatable :: content
        integer :: n, i, k, refused, read_well, from

        call make_seeds(seeds, n)
        stream = new_stream(12_i8, 0, 0, 1, 1)
        refused = 0
        read_well = 0
        do i = 1, EXECUTIONS
            k = 1 + int(n*stream%uniform())
            ! One in four times the header may be hit, too.
            from = seeds(k)%records_begin
            if (stream%uniform() < 0.25_dp) from = 1
            call change(seeds(k)%content, from, stream, content)
            call make_file(seeds(k)%name, content)
            if (.not. allocated(error)) &
                call try(error, seeds(k)%name, content, from == seeds(k)%records_begin, from, refused, read_well)
            if (allocated(error)) then
                error%message = 'execution '//integer_text(i)//', '//seeds(k)%name//': '//error%message
                return
            end if
        end do
        ! Both happen, or the changes are none.
        call check(error, refused > EXECUTIONS/10 .and. read_well > EXECUTIONS/10, &
                   integer_text(refused)//' refused, '//integer_text(read_well)//' read')
    end subroutine test_changed

    !> Files of our own making, and official ones where they are at hand.
    subroutine make_seeds(seeds, n)
        type(seed_t), intent(inout) :: seeds(:)
        integer, intent(out) :: n
        character(5), parameter :: MADE(8) = ['CLK1B', 'MAG1A', 'TNK1B', 'ACC1A', 'GNV1A', 'VCM1B', 'THR1A', 'MAS1B']
        character(5), parameter :: OFFICIAL(4) = ['ACC1A', 'SCA1A', 'GNI1B', 'TIM1B']
        type(text_file_t) :: file
        type(error_t), allocatable :: failure
        integer :: i, form

        n = 0
        do i = 1, size(MADE)
            do form = 0, 1
                n = n + 1
                seeds(n)%name = 'fuzz/'//MADE(i)//'_2020-02-01_A_04'//trim(merge('.dat', '.txt', form == 0))
                call write_made(MADE(i), form == 0, FOLDER//'fuzz.out')
                call read_bytes(FOLDER//'fuzz.out', seeds(n)%content)
                seeds(n)%records_begin = index(seeds(n)%content, 'END OF HEADER') + 81
            end do
        end do
        do i = 1, size(OFFICIAL)
            if (.not. file_exists(SAMPLES//OFFICIAL(i)//DAY)) cycle
            call read_text_file(SAMPLES//OFFICIAL(i)//DAY, file, failure)
            if (allocated(failure)) cycle
            n = n + 1
            seeds(n)%name = 'fuzz/'//OFFICIAL(i)//DAY
            seeds(n)%content = file%text
            seeds(n)%records_begin = index(file%text, '# End of YAML header')
            seeds(n)%records_begin = seeds(n)%records_begin + index(file%text(seeds(n)%records_begin:), LF)
        end do
        call execute_command_line('mkdir -p '//FOLDER//'fuzz')
    end subroutine make_seeds

    subroutine read_bytes(path, content)
        character(*), intent(in) :: path
        character(:), allocatable, intent(out) :: content
        integer :: unit, length

        open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read')
        inquire (unit=unit, size=length)
        allocate (character(length) :: content)
        read (unit) content
        close (unit)
    end subroutine read_bytes

    !> Twelve records with plain numbers.
    subroutine write_made(product, binary, path)
        character(*), intent(in) :: product, path
        logical, intent(in) :: binary
        type(level1_layout_t) :: layout
        type(level1_writer_t) :: writer
        type(level1_header_t) :: header
        type(error_t), allocatable :: failure
        real(dp), allocatable :: values(:)
        integer :: i, k

        call level1_layout(product, .false., layout, failure)
        header%satellite = 'A'
        header%records = 12
        call writer%open(path, layout, binary, header, failure)
        allocate (values(size(layout%fields)))
        do i = 1, 12
            do k = 1, size(values)
                values(k) = mod(i*k, 7)
                if (layout%fields(k)%kind == KIND_F8) values(k) = -1.064995712362181e-5_dp*i*k
                if (layout%fields(k)%kind == KIND_F4) values(k) = 0.375_dp*i*k
                if (layout%fields(k)%kind == KIND_LETTER) values(k) = iachar('E')
                if (layout%fields(k)%name == 'tank_id') values(k) = 1 + mod(i, 2)
            end do
            values(1) = 116769600 + 5*i
            values(layout%id) = iachar('A')
            if (layout%time_ref > 0) values(layout%time_ref) = iachar('R')
            if (layout%prod_flag > 0) values(layout%prod_flag) = merge(3, 5, mod(i, 3) == 0)
            if (layout%channels > 0) values(layout%channels) = mod(i, 3)
            call writer%record(values)
        end do
        call writer%commit(failure)
    end subroutine write_made

    !> One to four random changes.
    subroutine change(original, from, stream, content)
        character(*), intent(in) :: original
        integer, intent(in) :: from                 !! Nothing before is changed
        type(random_stream_t), intent(inout) :: stream
        character(:), allocatable, intent(out) :: content
        character(20), parameter :: WORDS(12) = [character(20) :: 'nan', '-inf', '1e400', '-', '1e-400', '99999999999999999999', &
                                                 '0x1F', '1,5', '+1.5D-3', 'END OF HEADER', '4294967296', '-1']
        integer :: i, at, length, to

        content = original
        do i = 1, 1 + int(4*stream%uniform()**2)
            if (len(content) <= from) return
            at = from + int((len(content) - from)*stream%uniform())
            length = min(1 + int(30*stream%uniform()**3), len(content) - at)
            select case (int(9*stream%uniform()))
            case (0)    ! any byte
                content(at:at) = achar(int(256*stream%uniform()))
            case (1)    ! a digit, point or blank
                content(at:at) = char_of('0123456789 .-+eE', stream)
            case (2)    ! left out
                content = content(:at - 1)//content(at + length:)
            case (3)    ! doubled
                content = content(:at + length - 1)//content(at:)
            case (4)    ! a word in place of some bytes
                content = content(:at - 1)//' '//trim(WORDS(1 + int(12*stream%uniform())))//' '//content(at + length:)
            case (5)    ! cut off
                if (stream%uniform() < 0.3_dp) content = content(:at)
            case (6)    ! one piece in place of another
                to = from + int((len(content) - from - length)*stream%uniform())
                if (to >= from .and. to + length - 1 <= len(content)) &
                    content(to:to + length - 1) = content(at:at + length - 1)
            case (7)    ! another kind of white space
                to = index(content(at:), ' ')
                if (to > 0) content(at + to - 1:at + to - 1) = char_of(achar(9)//achar(10)//achar(13)//achar(11)//'  ', stream)
            case default    ! a bit
                content(at:at) = achar(ieor(iachar(content(at:at)), 2**int(8*stream%uniform())))
            end select
        end do
    end subroutine change

    character(1) function char_of(letters, stream)
        character(*), intent(in) :: letters
        type(random_stream_t), intent(inout) :: stream
        integer :: i

        i = 1 + int(len(letters)*stream%uniform())
        char_of = letters(i:i)
    end function char_of

    !> Reads a file by every way; when nothing is said to be wrong, its numbers must be those of the content.
    subroutine try(error, name, content, header_is_whole, from, refused, read_well)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name, content
        logical, intent(in) :: header_is_whole
        integer, intent(in) :: from             !! Where the records begin, if the header is whole
        integer, intent(inout) :: refused, read_well
        type(level1_records_t) :: records
        type(level1_summary_t) :: summary
        type(error_t), allocatable :: failure, failure_of_summary

        call read_level1(FOLDER//name, records, failure)
        call summarise_level1(FOLDER//name, summary, failure_of_summary, with_fields=.true.)
        if (allocated(failure)) then
            refused = refused + 1
            call check_says(error, failure%message, name)
            return
        end if
        read_well = read_well + 1
        if (allocated(failure_of_summary)) then
            call test_failed(error, 'read, but not summarised: '//message_of(failure_of_summary))
            return
        end if
        call check(error, summary%records == records%count + records%duplicates, 'records lost')
        if (allocated(error) .or. .not. header_is_whole) return
        if (records%header%binary) then
            call compare_bytes(error, name, content(from:))
        else
            call compare_words(error, name, content(from:))
        end if
    end subroutine try

    !> Every word of the text, read by the run-time library, is the value that the reader gives.
    subroutine compare_words(error, name, text)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name, text
        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        type(error_t), allocatable :: failure
        character(:), allocatable :: word
        integer :: at, i, k
        real(dp) :: expected, found
        logical :: ok

        call reader%open(FOLDER//name, failure)
        if (.not. allocated(failure)) call reader%next(block, failure)
        if (failed(error, failure)) return
        at = 1
        do i = 1, block%count
            do k = 1, size(reader%layout%fields)
                associate (field => reader%layout%fields(k))
                    if (field%bit >= 0) then
                        if (.not. btest(nint(block%values(i, reader%layout%prod_flag), i8), field%bit)) cycle
                    else if (field%channel > 0) then
                        if (field%channel > nint(block%values(i, reader%layout%channels))) cycle
                    end if
                    call next_word(text, at, word)
                    found = block%values(i, k)
                    ! Satellite and time frame may stand in either order.
                    if (k == reader%layout%id .or. k == reader%layout%time_ref) then
                        ok = word == achar(nint(block%values(i, reader%layout%id)))
                        if (reader%layout%time_ref > 0) &
                            ok = ok .or. word == achar(nint(block%values(i, reader%layout%time_ref)))
                    else if (field%kind == KIND_LETTER) then
                        ok = word == achar(nint(found))
                    else if (field%kind == KIND_FLAG8 .or. field%kind == KIND_FLAG32) then
                        expected = 0
                        ok = verify(word, '01') == 0
                        call add_bits(word, expected)
                        ok = ok .and. abs(expected - found) <= 0
                    else if (found /= found) then
                        ok = scan(lower_case(word), 'n') > 0
                    else
                        call parse_real(word, expected, ok)
                        ok = ok .and. abs(expected - found) <= 0
                    end if
                    if (.not. ok) then
                        call test_failed(error, 'record '//integer_text(i)//', '//trim(field%name)//': the word is '//word)
                        return
                    end if
                end associate
            end do
        end do
        call next_word(text, at, word)
        call check(error, word, '', 'words are left over')
    end subroutine compare_words

    subroutine add_bits(word, number)
        character(*), intent(in) :: word
        real(dp), intent(inout) :: number
        integer :: i

        do i = 1, len(word)
            number = 2*number + (iachar(word(i:i)) - iachar('0'))
        end do
    end subroutine add_bits

    subroutine next_word(text, at, word)
        character(*), intent(in) :: text
        integer, intent(inout) :: at
        character(:), allocatable, intent(out) :: word
        character(*), parameter :: WHITE = ' '//achar(9)//achar(10)//achar(11)//achar(12)//achar(13)
        integer :: first, last

        word = ''
        if (at > len(text)) return
        first = verify(text(at:), WHITE)
        if (first == 0) return
        first = at + first - 1
        last = scan(text(first:), WHITE)
        if (last == 0) last = len(text) - first + 2
        last = first + last - 2
        word = text(first:last)
        at = last + 1
    end subroutine next_word

    !> The records written again are the bytes that were read, but for numbers that are not finite.
    subroutine compare_bytes(error, name, bytes)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name, bytes
        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        type(level1_writer_t) :: writer
        type(error_t), allocatable :: failure
        character(:), allocatable :: again
        integer :: i, first

        call reader%open(FOLDER//name, failure)
        if (.not. allocated(failure)) call reader%next(block, failure)
        if (.not. allocated(failure)) call writer%open(FOLDER//'fuzz.again', reader%layout, .true., reader%header, failure)
        if (.not. allocated(failure)) then
            do i = 1, block%count
                call writer%record(block%values(i, :))
            end do
            call writer%commit(failure)
        end if
        call check_passes(error, failure)
        if (allocated(error) .or. any(reader%not_finite > 0)) return
        call read_bytes(FOLDER//'fuzz.again', again)
        first = index(again, 'END OF HEADER') + 81
        call check(error, len(again) - first + 1, len(bytes), 'length of the records')
        ! Satellite and time frame may stand in either order.
        do i = 1, len(bytes)
            if (again(first + i - 1:first + i - 1) == bytes(i:i)) cycle
            if (reader%layout%time_ref > 0 .and. scan(bytes(i:i), 'ABCDGR') == 1) cycle
            call test_failed(error, 'byte '//integer_text(i)//' of the records is another')
            return
        end do
    end subroutine compare_bytes
end module test_level1_fuzz
