!> Which of several processes this one is, as launchers and job arrays say by environment variables.
!>
!> A job array and a launcher may stand one in the other: an array of jobs, each with several processes, counts them all.
module gracecg_cli_launcher
    use gracecg_base_text, only: parse_integer, integer_text
    implicit none
    private
    public :: find_place

    !> Which launchers are known, in words
    character(*), parameter :: PLACE_ADVICE = 'known are job arrays of Slurm, SGE and (with auto/N, for they do not say '// &
        'how many there are) PBS, and processes started by srun, Open MPI''s or MPICH''s mpirun'

    !> Launchers that number their processes from 0: name, variables of rank and size.
    character(24), parameter :: LAUNCHERS(3, 3) = reshape([character(24) :: &
        'Open MPI', 'OMPI_COMM_WORLD_RANK', 'OMPI_COMM_WORLD_SIZE', &
        'MPICH', 'PMI_RANK', 'PMI_SIZE', &
        'Slurm step', 'SLURM_PROCID', 'SLURM_STEP_NUM_TASKS'], [3, 3])
    !> Job arrays: name, variables of index, first, last, step.
    character(24), parameter :: ARRAYS(5, 2) = reshape([character(24) :: &
        'Slurm array', 'SLURM_ARRAY_TASK_ID', 'SLURM_ARRAY_TASK_MIN', 'SLURM_ARRAY_TASK_MAX', 'SLURM_ARRAY_TASK_STEP', &
        'SGE array', 'SGE_TASK_ID', 'SGE_TASK_FIRST', 'SGE_TASK_LAST', 'SGE_TASK_STEPSIZE'], [5, 2])
    !> Of PBS Pro or OpenPBS, and of Torque
    character(24), parameter :: PBS_INDEX(2) = [character(24) :: 'PBS_ARRAY_INDEX', 'PBS_ARRAYID']

contains

    !> The number of this process and how many there are, from 1 on. `problem` says why they cannot be found.
    subroutine find_place(given, place, places, problem)
        integer, intent(in) :: given            !! How many jobs the array has; 0: the variables say
        integer, intent(out) :: place, places   !! Number of this process, number of all
        character(:), allocatable, intent(out) :: problem   !! Not allocated: all is well

        integer :: job, jobs, rank, ranks

        call find_job(given, job, jobs, problem)
        if (.not. allocated(problem)) call find_rank(rank, ranks, problem)
        place = 0
        places = 0
        if (allocated(problem)) return
        if (jobs == 0 .and. ranks == 0) then
            problem = 'no variable of the environment tells of a launcher or a job array; '//PLACE_ADVICE
            return
        end if
        jobs = max(jobs, 1)
        ranks = max(ranks, 1)
        place = job*ranks + rank + 1
        places = jobs*ranks
    end subroutine find_place

    !> Place in a job array, from 0 on; jobs = 0: there is none.
    subroutine find_job(given, job, jobs, problem)
        integer, intent(in) :: given
        integer, intent(out) :: job, jobs
        character(:), allocatable, intent(out) :: problem

        integer :: i, index, first, last, step
        logical :: found(4)

        job = 0
        jobs = 0
        do i = 1, size(ARRAYS, 2)
            call get_number(ARRAYS(2, i), index, found(1))
            if (.not. found(1)) cycle
            call get_number(ARRAYS(3, i), first, found(2))
            call get_number(ARRAYS(4, i), last, found(3))
            call get_number(ARRAYS(5, i), step, found(4))
            if (.not. found(4)) step = 1
            if (.not. all(found(:3)) .or. step < 1 .or. index < first .or. index > last) then
                problem = trim(ARRAYS(1, i))//': the variables '//trim(ARRAYS(2, i))//', '//trim(ARRAYS(3, i))//', '// &
                          trim(ARRAYS(4, i))//', '//trim(ARRAYS(5, i))//' do not agree'
                return
            end if
            job = (index - first)/step
            jobs = (last - first)/step + 1
            if (given > 0 .and. given /= jobs) problem = trim(ARRAYS(1, i))//' has '//integer_text(jobs)//' jobs, not '// &
                                                         integer_text(given)
            return
        end do
        do i = 1, size(PBS_INDEX)
            call get_number(PBS_INDEX(i), index, found(1))
            if (.not. found(1)) cycle
            job = index - 1
            jobs = given
            if (given == 0) then
                problem = 'PBS does not say how many jobs an array has: write auto/N for an array from 1 to N'
            else if (index < 1 .or. index > given) then
                problem = trim(PBS_INDEX(i))//' = '//integer_text(index)//' is not from 1 to '//integer_text(given)
            end if
            return
        end do
        if (given > 0) problem = 'auto/N is for job arrays, and there is none; '//PLACE_ADVICE
    end subroutine find_job

    !> Place among the processes of a launcher, from 0 on; ranks = 0: there is none.
    subroutine find_rank(rank, ranks, problem)
        integer, intent(out) :: rank, ranks
        character(:), allocatable, intent(out) :: problem

        logical :: found(2)
        integer :: i

        do i = 1, size(LAUNCHERS, 2)
            call get_number(LAUNCHERS(2, i), rank, found(1))
            call get_number(LAUNCHERS(3, i), ranks, found(2))
            if (.not. all(found)) cycle
            if (rank < 0 .or. rank >= ranks) problem = trim(LAUNCHERS(1, i))//': '//trim(LAUNCHERS(2, i))//' = '// &
                integer_text(rank)//' is not from 0 to '//integer_text(ranks - 1)
            return
        end do
        rank = 0
        ranks = 0
    end subroutine find_rank

    !> A whole number of the environment.
    subroutine get_number(name, number, found)
        character(*), intent(in) :: name
        integer, intent(out) :: number
        logical, intent(out) :: found       !! There is such a variable, with a number in it

        character(32) :: text
        integer :: status

        number = 0
        call get_environment_variable(trim(name), text, status=status)
        found = status == 0
        if (found) call parse_integer(trim(text), number, found)
    end subroutine get_number
end module gracecg_cli_launcher
