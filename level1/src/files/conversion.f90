!> Level-1 text as binary and binary as text: the same records in the other form.
module gracecg_level1_conversion
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_products, only: SATELLITES
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    use gracecg_level1_summary, only: level1_summary_t, summarise_level1
    use gracecg_level1_writer, only: level1_writer_t
    implicit none
    private
    public :: convert_level1

contains

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
