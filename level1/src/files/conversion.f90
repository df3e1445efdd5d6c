!> Level-1 text as binary and binary as text: the same records in the other form. And orbits, attitudes and other series as files of
!> others (GROOPS, CCSDS), and from them.
module gracecg_level1_conversion
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append
    use gracecg_files_file, only: input_stream_t
    use gracecg_level1_exchange_forms, only: write_ccsds, read_ccsds, CCSDS_MARK, write_groops, read_groops
    use gracecg_level1_exchange_series, only: exchange_series_t, series_of_level1, write_as_level1, kind_of_product
    use gracecg_level1_header, only: level1_header_t, product_of_file_name
    use gracecg_level1_products, only: SATELLITES
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    use gracecg_level1_summary, only: level1_summary_t, summarise_level1
    use gracecg_level1_writer, only: level1_writer_t
    implicit none
    private
    public :: convert_level1, exchange_level1, FORMS

    !> Forms of a file that is written: the other one of Level-1 (of a file of others: Level-1 text), GROOPS, CCSDS
    character(6), parameter :: FORMS(3) = [character(6) :: 'level1', 'groops', 'ccsds']

contains

    !> Writes a file in a form: a Level-1 file in that of others, a file of others, which is recognised by its first bytes, as a
    !> Level-1 file. Fails as reading and writing do.
    subroutine exchange_level1(path, out, form, warnings, error)
        character(*), intent(in) :: path                        !! Of the file to read
        character(*), intent(in) :: out                         !! Of the file to write; of Level-1 its name says the product
        character(*), intent(in) :: form                        !! One of FORMS
        type(string_t), allocatable, intent(out) :: warnings(:) !! What is to be known
        type(error_t), allocatable, intent(out) :: error

        type(exchange_series_t) :: series
        type(input_stream_t) :: stream
        character(64) :: first
        integer :: n, wanted

        call stream%open(path, error)
        if (.not. allocated(error)) call stream%read(first, n, error)
        if (allocated(error)) return
        call stream%close()
        first(n + 1:) = ' '
        wanted = kind_of_product(product_of_file_name(out))
        if (form /= 'level1') then
            call series_of_level1(path, series, error)
            if (.not. allocated(error) .and. form == 'groops') call write_groops(series, out, error)
            if (.not. allocated(error) .and. form == 'ccsds') call write_ccsds(series, out, error)
            if (series%axes == 'E' .and. .not. allocated(error)) &
                call append(series%remarks, 'Level-1 files do not say which ITRF the orbit is in: ITRF2014 is written')
        else if (index(first, CCSDS_MARK) == 1 .or. index(first, 'groops ') == 1 .or. &
                 (wanted > 0 .and. scan(first, '0123456789') == verify(first, ' '))) then
            if (index(first, CCSDS_MARK) == 1) then
                call read_ccsds(path, series, error)
            else
                call read_groops(path, wanted, series, error)
            end if
            if (.not. allocated(error)) call write_as_level1(series, out, error)
        else
            call convert_level1(path, out, warnings, error)
            return
        end if
        if (.not. allocated(error)) call move_alloc(series%remarks, warnings)
    end subroutine exchange_level1

    !> Writes the records of a file in the other form: of text binary, of binary text (that of GRACE-FO for
    !> satellites C and D). Fails when the file is broken, its product has no binary form, or it cannot be written.
    subroutine convert_level1(path, out, warnings, error)
        character(*), intent(in) :: path                        !! Of the file to read
        character(*), intent(in) :: out                         !! Of the file to write
        type(string_t), allocatable, intent(out) :: warnings(:) !! Of reading, and what could not be kept
        type(error_t), allocatable, intent(out) :: error

        type(level1_summary_t) :: summary
        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        type(level1_writer_t) :: writer
        type(level1_header_t) :: header
        integer :: i

        allocate (warnings(0))
        if (path == out) then
            call fail(error, trim(path)//': input and output are the same file')
            return
        end if
        call summarise_level1(path, summary, error, with_fields=.false.)    ! the header tells what will follow
        if (allocated(error)) return
        header = summary%header
        header%satellite = summary%satellite
        if (scan(header%satellite, SATELLITES) == 0) header%satellite = 'C'
        header%records = int(summary%records)
        if (summary%records > 0) then
            header%first_time = real(summary%first_seconds, dp) + summary%first_fraction
            header%last_time = real(summary%last_seconds, dp) + summary%last_fraction
        end if
        call reader%open(path, error)
        if (.not. allocated(error)) call writer%open(out, reader%layout, .not. header%binary, header, error)
        if (allocated(error)) return
        do
            call reader%next(block, error)
            if (allocated(error)) then
                call writer%discard()
                return
            end if
            if (block%count == 0) exit
            do i = 1, block%count
                call writer%record(block%values(i, :))
            end do
        end do
        call writer%commit(error)
        if (allocated(error)) return
        warnings = [reader%warnings, writer%losses()]
    end subroutine convert_level1
end module gracecg_level1_conversion
