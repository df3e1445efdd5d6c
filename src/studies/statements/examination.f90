!> A statement of CSR-TM-00-01 while it is examined: rows of errors by theory and runs, and the verdict by counts.
module gracecg_studies_examination
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: progress_t, tell
    use gracecg_base_text, only: share_text
    use gracecg_simulation_simulator, only: simulator_t, error_switches_t, new_switched_simulator
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_studies_monte_carlo, only: error_study_t, study_errors
    implicit none
    private
    public :: claim_t, statement_row_t, statement_t, examination_t
    public :: mm_text, range_text, plain_text
    public :: HOLDS, HOLDS_IN_PART, HOLDS_NOT, VERDICT_WORDS
    public :: SINGLE_ALGORITHM, COMBINED_ALGORITHM, FRONT_CASES, BEST_ACCURACY, SMALL_SHARE

    integer, parameter :: HOLDS = 1, HOLDS_IN_PART = 2, HOLDS_NOT = 3   !! Verdicts
    !> The verdicts in words, by HOLDS, HOLDS_IN_PART, HOLDS_NOT
    character(13), parameter :: VERDICT_WORDS(3) = [character(13) :: 'holds', 'holds in part', 'does not hold']
    character(*), parameter :: SINGLE_ALGORITHM = 'assest-fde'      !! Of the statements about manoeuvres
    character(*), parameter :: COMBINED_ALGORITHM = 'ascfest'       !! Of the statements about estimates
    !> The cases of the report's front satellite
    character(7), parameter :: FRONT_CASES(3) = [character(7) :: 'front-1', 'front-2', 'front-3']
    real(dp), parameter :: BEST_ACCURACY(3) = [0.02_dp, 0.01_dp, 0.02_dp]*MILLIMETRE    !! Section 7.1(3), x, y, z
    real(dp), parameter :: SMALL_SHARE = 0.1_dp         !! Of the variance of an error: a small impact, 5 % of the RMS

    !> What the report says.
    type :: claim_t
        character(12) :: name = ''          !! As on the command line
        character(40) :: place = ''         !! In the report
        character(240) :: claim = ''        !! What the report says
        character(200) :: method = ''       !! What is computed
    end type claim_t

    !> One setting of a statement's study.
    type, extends(error_study_t) :: statement_row_t
        character(16) :: case_name = ''     !! Of the report, or several joined by +
        character(40) :: setting = ''       !! What is changed
        real(dp) :: condition = 0           !! Of a normal matrix; 0: not asked for
        real(dp) :: torque_ratio = 0        !! Rods' torque over the sum of all others, RMS; 0: not asked for
        real(dp) :: stars = 0               !! In the field of a star camera, on average; 0: not asked for
        real(dp) :: camera_sigma(3) = 0     !! Of its attitude, about camera x, y, boresight, rad; 0: not asked for
    end type statement_row_t

    !> A statement and what is found.
    type, extends(claim_t) :: statement_t
        integer :: verdict = 0              !! HOLDS, HOLDS_IN_PART or HOLDS_NOT
        character(200) :: found = ''        !! The verdict in a sentence, with the numbers that make it
        character(400) :: details = ''      !! More of them
        type(statement_row_t), allocatable :: rows(:)   !! The numbers behind it
    end type statement_t

    !> A statement while it is examined. After a failure its procedures do nothing.
    type, extends(statement_t) :: examination_t
        integer :: runs = 0, threads = 1    !! Of each Monte Carlo, 0: theory alone; in parallel
        integer(i8) :: seed = 1             !! Of the random numbers
    contains
        procedure :: add_errors             !! A row of errors
        procedure :: conclude               !! Verdict and finding by counts
        procedure :: conclude_halves        !! The same of two halves
    end type examination_t

contains

    !> Theory of a calibration with an algorithm, and runs beside it: a row.
    subroutine add_errors(self, calibration, algorithm, setting, error, progress, switches)
        class(examination_t), intent(inout) :: self
        type(calibration_t), intent(in) :: calibration
        character(*), intent(in) :: algorithm, setting    !! Of the estimates; what is changed, in words
        type(error_t), allocatable, intent(inout) :: error
        class(progress_t), intent(inout), optional :: progress
        type(error_switches_t), intent(in), optional :: switches    !! Error sources that act; all when absent

        type(error_switches_t) :: acting
        type(statement_row_t) :: row
        type(simulator_t) :: simulator

        if (allocated(error)) return
        row%case_name = trim(calibration%case%name)     ! of the report: 7 letters
        row%setting = setting
        call tell(progress, trim(self%name)//', '//trim(row%case_name)//', '//setting)
        if (present(switches)) acting = switches
        call new_switched_simulator(calibration%case, acting, simulator, error)
        if (.not. allocated(error)) call study_errors(simulator, algorithm, calibration%options, self%seed, self%runs, &
                                                      self%threads, row, error, progress)
        if (.not. allocated(error)) self%rows = [self%rows, row]
    end subroutine add_errors

    !> A statement holds when all of so many things are met, and in part when some are.
    subroutine conclude(self, met, of, of_what, found)
        class(examination_t), intent(inout) :: self
        integer, intent(in) :: met, of    !! Things that hold, of so many
        character(*), intent(in) :: of_what         !! In the plural
        character(*), intent(in) :: found           !! A sentence, its first letter small

        self%verdict = merge(HOLDS, merge(HOLDS_NOT, HOLDS_IN_PART, met == 0), met == of)
        select case (self%verdict)
        case (HOLDS)
            self%found = 'Holds: '//found
        case (HOLDS_NOT)
            self%found = 'Does not hold: '//found
        case default
            self%found = 'Holds for '//share_text(met, of)//' '//of_what//': '//found
        end select
    end subroutine conclude

    !> A statement of two halves holds when both do, and in part when one does.
    subroutine conclude_halves(self, holds_half, halves, found)
        class(examination_t), intent(inout) :: self
        logical, intent(in) :: holds_half(2)        !! Whether each half does
        character(*), intent(in) :: halves(2)       !! In words
        character(*), intent(in) :: found           !! As of conclude

        self%verdict = merge(HOLDS, merge(HOLDS_IN_PART, HOLDS_NOT, any(holds_half)), all(holds_half))
        select case (self%verdict)
        case (HOLDS)
            self%found = 'Holds: '//found
        case (HOLDS_NOT)
            self%found = 'Does not hold: '//found
        case default
            self%found = 'Holds for the '//trim(halves(findloc(holds_half, .true., 1)))//' only: '//found
        end select
    end subroutine conclude_halves

    !> A number without what stands before and behind its digits.
    pure function plain_text(value, form) result(text)
        real(dp), intent(in) :: value    !! Any unit
        character(*), intent(in) :: form            !! Of Fortran, at most 16 columns
        character(16) :: text               !! Blanks behind it, as of the texts below

        integer :: last

        write (text, form) value
        text = adjustl(text)
        last = len_trim(text)
        if (text(last:last) == '.') text(last:last) = ' '
    end function plain_text

    !> Millimetres with two significant digits and more.
    pure function mm_text(value) result(text)
        real(dp), intent(in) :: value               !! m
        character(16) :: text

        text = plain_text(value/MILLIMETRE, '(f10.4)')
    end function mm_text

    !> The least and the greatest part of 1, in percent.
    pure function range_text(parts) result(text)
        real(dp), intent(in) :: parts(:, :)    !! Parts of 1
        character(36) :: text

        text = trim(plain_text(100*minval(parts), '(f6.0)'))//' to '//plain_text(100*maxval(parts), '(f6.0)')
    end function range_text
end module gracecg_studies_examination
